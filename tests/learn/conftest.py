"""A small synthetic map, a training on it, and the nodes of the small real map, that the tests of this folder share."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from tiny_map import grown, judged, parts

from gaitflow.config.scenario import Learning
from gaitflow.config.tasks import Task
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.dataset.labels import gait_costs, label_tasks
from gaitflow.learn.train import Training, train

__all__ = ["grown", "judged", "parts"]

LEARNING = Learning(
    folds=3, hidden_layers=((100, 80, 50),), learning_rates=(1e-2,), weight_decays=(1e-2,), max_epochs=60
)
PATTERNS = ("0111/1101", "0110/1100", "0001/0100")
WALK, GALLOP, BOUND = (gait_of(Pattern.from_text(text)).text for text in PATTERNS)


def cost_surfaces(v: float, t: float) -> dict[str, float]:
    """Walking below 0.8 m/s, gallop above, bounding in the corner of long cycles; infeasible beyond v T = 3.2 m.

    Walking is infeasible above 1.4 m/s, and ties with gallop at 0.8 m/s.
    """
    surfaces = {WALK: 1.0 + 2.0 * v, GALLOP: 1.8 + v, BOUND: 4.9 + 0.25 * v - t}
    if v * t > 3.2:
        return {}
    return {gait: cost for gait, cost in surfaces.items() if gait != WALK or v <= 1.4}


def frames(tasks: list[Task]) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Labels and gait costs of tasks on the surfaces."""
    rows = [
        {"speed": task.speed, "cycle_duration": task.cycle_duration, "split": task.split, "pattern": gait}
        | {"gait": gait, "status": "solved", "cost": cost, "violation": 1e-9}
        for task in tasks
        for gait, cost in cost_surfaces(task.speed, task.cycle_duration).items()
    ]
    costs = gait_costs(pd.DataFrame(rows), ("F", "H"))
    return label_tasks(costs, tasks, tie_tolerance=1e-3), costs


@pytest.fixture(scope="session")
def learning() -> Learning:
    """Settings small enough for a test."""
    return LEARNING


@pytest.fixture(scope="session")
def synthetic_map() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Labels and gait costs of a grid of 8 by 6 tasks and 20 held-out ones."""
    grid = [Task(float(v), float(t), "grid") for t in np.linspace(0.4, 1.6, 6) for v in np.linspace(0.1, 2.3, 8)]
    drawn = np.random.default_rng(0).uniform((0.1, 0.4), (2.3, 1.6), (20, 2))
    return frames(grid + [Task(float(v), float(t), "held_out") for v, t in drawn])


@pytest.fixture(scope="session")
def training(synthetic_map: tuple[pd.DataFrame, pd.DataFrame]) -> Training:
    """All methods trained on the synthetic map."""
    return train(*synthetic_map, LEARNING)
