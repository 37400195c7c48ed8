from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from gaitflow.config.scenario import Scenario
from gaitflow.problem.friction import friction_rows
from gaitflow.core.layout import layout_of


def test_a_force_obeys_the_rows_exactly_inside_the_pyramid(either: Scenario) -> None:
    layout, friction = layout_of(either), 0.6
    legs, d = layout.legs, layout.dimension
    u = ca.SX.sym("u", layout.nu)
    rows = ca.Function("rows", [u], [friction_rows(layout, friction, u)])
    assert rows.numel_out(0) == legs * 2 * (d - 1)
    rng = np.random.default_rng(0)
    seen = set()
    for _ in range(200):
        forces = rng.uniform(-1.0, 1.0, (legs, d)) * ([1.0] * (d - 1) + [2.0])
        found = rows(np.append(forces, rng.normal(size=legs * d))).full().reshape(legs, -1)
        inside = (np.abs(forces[:, :-1]) <= friction * forces[:, -1:]).all(axis=1)
        np.testing.assert_array_equal((found <= 0).all(axis=1), inside)
        seen |= set(inside.tolist())
    assert seen == {True, False}


def test_each_row_is_the_distance_to_one_face(anymal: Scenario) -> None:
    layout = layout_of(anymal)
    u = np.zeros(layout.nu)
    u[3:6] = (2.0, -3.0, 10.0)  # the second leg
    rows = ca.DM(friction_rows(layout, 0.5, ca.DM(u))).full().reshape(4, 4)
    assert rows[1] == pytest.approx([-3.0, -7.0, -8.0, -2.0])
    assert not rows[[0, 2, 3]].any()
