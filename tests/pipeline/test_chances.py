"""The classifier that a map in the making plans with."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from surfaces import BOUND, GALLOP, WALK, cost_surfaces
from tasks_at import at

from gaitflow.config.file import ConfigError
from gaitflow.config.scenario import Learning
from gaitflow.core.domain import Domain
from gaitflow.dataset.labels import gait_costs, label_tasks
from gaitflow.learn import installed
from gaitflow.pipeline import chances
from gaitflow.pipeline.chances import chances_of, check_trainable, learning_of, planning_of
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.rivals import FEW_AXES

AXES = ("speed", "cycle_duration")
OTHER = "0011/1100"  # competes somewhere, and is the best nowhere
SPEEDS, DURATIONS = np.linspace(0.1, 2.3, 8).tolist(), np.linspace(0.4, 1.2, 6).tolist()


def scenario(axes: Sequence[str] = AXES, methods: tuple[str, ...] = ("knn",)) -> Any:
    tasks = SimpleNamespace(space=SimpleNamespace(ranged=tuple(axes), fixed=()), ranges={}, adaptive=None)
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


@pytest.mark.parametrize(("axes", "is_trained"), [(FEW_AXES, False), (FEW_AXES + 1, True), (FEW_AXES + 2, True)])
def test_a_classifier_is_trained_where_plans_ask_for_it(
    monkeypatch: pytest.MonkeyPatch, axes: int, is_trained: bool
) -> None:
    monkeypatch.setattr(chances, "chances_of", lambda *_: "trained")
    monkeypatch.setattr(chances, "Planning", lambda _, atlas, found: found)
    made = SimpleNamespace(scenario=scenario([f"axis {n}" for n in range(axes)]), built=lambda: None)
    assert planning_of(made) == ("trained" if is_trained else None)  # type: ignore[arg-type,comparison-overlap]


def test_what_trains_a_classifier_is_told_by_a_digest() -> None:
    more = [f"axis {n}" for n in range(FEW_AXES + 1)]
    assert learning_of(scenario(more[1:])) is None
    found = learning_of(scenario(more))
    assert found == learning_of(scenario(more)) and found != learning_of(scenario(more, ("svm",)))


def test_what_cannot_be_trained_is_said_before_anything_is_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(installed, "find_spec", lambda _: None)
    more = [f"axis {n}" for n in range(FEW_AXES + 1)]
    check_trainable(scenario(methods=("mlp",)))
    check_trainable(scenario(more))
    with pytest.raises(ConfigError, match="needs PyTorch"):
        check_trainable(scenario(more, ("mlp", "knn")))
