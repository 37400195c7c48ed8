from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from gaitflow.core.trajectory import Trajectory
from gaitflow.dataset.gaps import gap_between_knots
from gaitflow.search.solution import Solution

G = 9.81
SCENARIO = {
    "robot": {"dimension": 2, "mass": 10.0, "inertia": [[1.0]]},
    "terrain": {"slope_deg": 0.0},
    "transcription": {"knots_per_phase": 1, "integrator": "euler"},
}


def falling(step: float) -> Solution:
    """Two Euler steps of free fall: each misses the parabola by g h^2 / 2."""
    times = np.array([0.0, step, 2 * step])
    base = np.zeros((3, 6))
    base[:, 4] = -G * times
    base[1:, 1] = np.cumsum(step * base[:-1, 4])
    feet, forces = np.zeros((3, 1, 2)), np.zeros((2, 1, 2))
    motion = Trajectory(times, base, feet, forces, np.zeros((2, 1, 2)), np.array([step, step]))
    return Solution(0.0, 2 * step, "grid", "00", "0", "", "", 0, "solved", "", 0.0, 0.0, 1, 1, 0.0, 0.0,
                    trajectory=motion)  # fmt: skip


@pytest.mark.parametrize("step", [0.01, 0.02])
def test_free_fall_by_euler_misses_the_parabola_by_half_g_h_squared(step: float) -> None:
    assert gap_between_knots(SCENARIO, falling(step)) == pytest.approx(G * step**2 / 2)


def test_without_a_motion_there_is_no_gap() -> None:
    assert math.isnan(gap_between_knots(SCENARIO, replace(falling(0.01), trajectory=None)))
