"""The classifier that a map in the making plans with."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from surfaces import BOUND, GALLOP, WALK, cost_surfaces
from tasks_at import at

from gaitflow.config.scenario import Learning
from gaitflow.core.domain import Domain
from gaitflow.dataset.labels import gait_costs, label_tasks
from gaitflow.pipeline import chances
from gaitflow.pipeline.chances import chances_of, learning_of, planning_of
from gaitflow.runtime.atlas import Atlas

AXES = ("speed", "cycle_duration")
OTHER = "0011/1100"  # competes somewhere, and is the best nowhere
SPEEDS, DURATIONS = np.linspace(0.1, 2.3, 8).tolist(), np.linspace(0.4, 1.2, 6).tolist()


def scenario(methods: tuple[str, ...] = ("knn",)) -> Any:
    tasks = SimpleNamespace(space=SimpleNamespace(ranged=AXES, fixed=()), ranges={}, adaptive=None)
    robot = SimpleNamespace(mirror=())
    return SimpleNamespace(name="small", tasks=tasks, robot=robot, learning=Learning(folds=3, methods=methods))


def making() -> Any:
    tasks = [at(speed, duration) for speed in SPEEDS for duration in DURATIONS]
    rows = [
        {"speed": task.speed, "cycle_duration": task.cycle_duration, "split": task.split, "pattern": gait, "gait": gait}
        | {"status": "solved", "cost": cost, "violation": 1e-9, "refined_cost": np.nan, "refined_knots": 0}
        for task in tasks
        for gait, cost in (cost_surfaces(task.speed, task.cycle_duration) | {OTHER: 9.0}).items()
    ]
    costs = gait_costs(pd.DataFrame(rows), ("F", "H"))
    return SimpleNamespace(
        scenario=scenario(),
        gaits=[GALLOP, OTHER, WALK, BOUND],
        costs=costs,
        labels=label_tasks(costs, tasks, tie_tolerance=1e-3, knots_per_phase=10),
        domain=Domain(dict(zip(AXES, (tuple(SPEEDS), tuple(DURATIONS)), strict=True)), np.ones((8, 6), dtype=bool)),
        built=lambda: Atlas.empty(AXES),
        tell=lambda text: None,
    )


def test_the_columns_are_the_gaits_of_the_map_in_the_making() -> None:
    made = making()
    found = chances_of(made, made.built())(np.array([[0.2, 0.5], [1.2, 0.5]]))
    assert found.shape == (2, len(made.gaits))
    assert found.sum(axis=1) == pytest.approx(1.0, abs=1e-5)
    assert [made.gaits[column] for column in found.argmax(axis=1)] == [WALK, GALLOP]
    assert not found[:, made.gaits.index(OTHER)].any(), "it is no label"


def test_plans_ask_the_classifier_that_would_be_published(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chances, "Planning", lambda *of: of)
    made = making()
    _, atlas, asked = planning_of(made)  # type: ignore[misc]
    assert atlas.axes == AXES, "of the map as it is"  # type: ignore[attr-defined]
    assert asked(np.array([[0.2, 0.5]])).argmax() == made.gaits.index(WALK)


def test_what_trains_a_classifier_is_told_by_a_digest() -> None:
    found = learning_of(scenario())
    assert found == learning_of(scenario()) and found != learning_of(scenario(methods=("svm",)))
