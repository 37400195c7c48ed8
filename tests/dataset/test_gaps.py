from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from gaitflow.core.task import Task
from gaitflow.core.trajectory import Trajectory
from gaitflow.dataset import load_solutions
from gaitflow.dataset.gaps import COLUMNS, COST_CHECK, GAP, motion_checks, with_motion_checks
from gaitflow.search.solution import Solution

G = 9.81
SCENARIO: dict[str, Any] = {
    "robot": {
        "dimension": 2,
        "mass": 10.0,
        "inertia": [[1.0]],
        "legs": [{"name": "F", "default_foot": [0.0, -1.0]}],
        "box": [1.0, 1.0],
    },
    "objective": {"force": 0.0, "normal_velocity": 1.0},
    "transcription": {"phases": 2, "knots_per_phase": 1, "integrator": "euler", "forces": "held"},
}


def falling(step: float) -> Solution:
    """Two Euler steps of free fall: each misses the parabola by g h^2 / 2."""
    times = np.array([0.0, step, 2 * step])
    base = np.zeros((3, 6))
    base[:, 4] = -G * times
    base[1:, 1] = np.cumsum(step * base[:-1, 4])
    feet, forces = np.zeros((3, 1, 2)), np.zeros((2, 1, 2))
    motion = Trajectory(times, base, feet, forces, forces, np.zeros((2, 1, 2)), np.array([step, step]))
    squares = step * (G * step) ** 2  # the sum over the knots of the normal velocity squared
    return Solution(
        Task.of({"cycle_duration": 2 * step}), "00", "0", "", "", 0, "solved", "", 1.1 * squares, 0.0, 1, 1, 0.0, 0.0,
        trajectory=motion,
    )  # fmt: skip


@pytest.mark.parametrize("step", [0.01, 0.02])
def test_free_fall_by_euler_misses_the_parabola_by_half_g_h_squared(step: float) -> None:
    checks = motion_checks(SCENARIO, falling(step))
    assert set(checks) == set(COLUMNS) and checks[GAP] == pytest.approx(G * step**2 / 2)
    assert checks[COST_CHECK] == pytest.approx(0.1)
    assert checks["friction_between_knots"] == checks["penetration_between_knots"] == 0.0


def test_without_a_motion_there_is_nothing_to_check() -> None:
    checks = motion_checks(SCENARIO, replace(falling(0.01), trajectory=None))
    assert all(math.isnan(value) for value in checks.values())


def test_every_label_is_checked_by_its_own_motion(checkout: Path) -> None:
    folder = checkout / "tests/data/datasets/half-cheetah-slope20-vibration/1.0.0"
    labels = pd.read_parquet(folder / "labels.parquet")
    checked = with_motion_checks(labels, load_solutions(folder))
    solved = (labels["status"] == "solved").to_numpy()
    assert (checked[list(COLUMNS)].notna().all(axis=1).to_numpy() == solved).all() and solved.any()
    # What these tables said of the motions under the same forces, by another integration.
    np.testing.assert_allclose(checked.loc[solved, GAP], labels.loc[solved, GAP], rtol=1e-3, atol=1e-6)
    assert checked.loc[solved, COST_CHECK].abs().max() < 1e-6
    assert checked["box_between_knots"].max() > 0.01  # Euler's motions of least effort leave the box between knots
