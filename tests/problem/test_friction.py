from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from terms import layout_of, numbers

from gaitflow.config.scenario import Scenario
from gaitflow.problem.friction import friction_rows


def test_a_force_obeys_the_rows_exactly_inside_the_pyramid(either: Scenario) -> None:
    legs, d = layout_of(either).legs, layout_of(either).dimension
    friction, symbols = ca.SX.sym("friction"), ca.SX.sym("forces", legs * d)
    rows = ca.Function("rows", [friction, symbols], [friction_rows(friction, ca.vertsplit(symbols, d))])
    assert rows.numel_out(0) == legs * 2 * (d - 1)
    rng = np.random.default_rng(0)
    seen = set()
    for _ in range(200):
        forces = rng.uniform(-1.0, 1.0, (legs, d)) * ([1.0] * (d - 1) + [2.0])
        found = rows(0.6, forces.ravel()).full().reshape(legs, -1)
        inside = (np.abs(forces[:, :-1]) <= 0.6 * forces[:, -1:]).all(axis=1)
        np.testing.assert_array_equal((found <= 0).all(axis=1), inside)
        seen |= set(inside.tolist())
    assert seen == {True, False}


def test_each_row_is_the_distance_to_one_face() -> None:
    forces = [ca.SX.zeros(3), ca.SX([2.0, -3.0, 10.0])]
    rows = numbers(friction_rows(ca.SX(0.5), forces)).reshape(2, 4)
    assert rows[1] == pytest.approx([-3.0, -7.0, -8.0, -2.0])
    assert not rows[0].any()
