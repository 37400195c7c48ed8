"""A small synthetic map, a training on it, and the small real map, that the tests of this folder share."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from surfaces import cost_surfaces
from tasks_at import at
from tiny_map import preferring, tiny

from gaitflow.config.scenario import Learning
from gaitflow.core.task import Task
from gaitflow.dataset.labels import gait_costs, label_tasks
from gaitflow.learn.train import Training, train

__all__ = ["preferring", "tiny"]

AXES = ("speed", "cycle_duration")

LEARNING = Learning(
    folds=3, hidden_layers=((100, 80, 50),), learning_rates=(1e-2,), weight_decays=(1e-2,), max_epochs=60
)


def frames(tasks: list[Task]) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Labels and gait costs of tasks on the surfaces."""
    rows = [
        {"speed": task.speed, "cycle_duration": task.cycle_duration, "split": task.split, "pattern": gait}
        | {"gait": gait, "status": "solved", "cost": cost, "violation": 1e-9}
        | {"refined_cost": np.nan, "refined_knots": 0}
        for task in tasks
        for gait, cost in cost_surfaces(task.speed, task.cycle_duration).items()
    ]
    costs = gait_costs(pd.DataFrame(rows), ("F", "H"))
    return label_tasks(costs, tasks, tie_tolerance=1e-3, knots_per_phase=10), costs


@pytest.fixture(scope="session")
def learning() -> Learning:
    """Settings small enough for a test."""
    return LEARNING


@pytest.fixture(scope="session")
def synthetic_map() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Labels and gait costs of a grid of 8 by 6 tasks and 20 held-out ones."""
    grid = [at(float(v), float(t)) for t in np.linspace(0.4, 1.6, 6) for v in np.linspace(0.1, 2.3, 8)]
    drawn = np.random.default_rng(0).uniform((0.1, 0.4), (2.3, 1.6), (20, 2))
    return frames(grid + [at(float(v), float(t), "held_out") for v, t in drawn])


@pytest.fixture(scope="session")
def training(synthetic_map: tuple[pd.DataFrame, pd.DataFrame]) -> Training:
    """All methods trained on the synthetic map."""
    return train(*synthetic_map, AXES, LEARNING)
