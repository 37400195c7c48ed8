from __future__ import annotations

import casadi as ca
import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.layout import layout_of
from gaitflow.problem.periodicity import periodicity_rows


def test_everything_repeats_but_the_way_forward(either: Scenario) -> None:
    """Eq. (3): base and feet advance by v T along the ground; sideways, heights, angles and velocities repeat."""
    layout, speed, cycle = layout_of(either), 1.3, 0.7
    first = np.random.default_rng(0).normal(size=layout.nx)
    ahead = np.zeros(layout.nx)
    ahead[[0, *(layout.nb + layout.dimension * np.arange(layout.legs))]] = speed * cycle
    rows = periodicity_rows(layout, ca.DM(first), ca.DM(first + ahead), ca.DM(speed), ca.DM(cycle))
    np.testing.assert_allclose(ca.DM(rows).full(), 0, atol=1e-14)
    for index in range(layout.nx):
        last = first + ahead
        last[index] += 0.25
        off = ca.DM(periodicity_rows(layout, ca.DM(first), ca.DM(last), ca.DM(speed), ca.DM(cycle))).full().ravel()
        np.testing.assert_allclose(off, 0.25 * (np.arange(layout.nx) == index), atol=1e-14)
