"""What stages hand on, and what they say when the stage before is missing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gaitflow.atlas.judge import Predictions
from gaitflow.config.scenario import Range, Scenario, load_scenario
from gaitflow.config.tasks import tasks_of
from gaitflow.pipeline import stages
from gaitflow.pipeline.atlas_record import atlas_record
from gaitflow.pipeline.json_file import read_json, write_json
from gaitflow.pipeline.workspace import Workspace
from gaitflow.runtime.atlas import Atlas


def scenario_of(checkout: Path, **axes: Range | float) -> Scenario:
    data = load_scenario(checkout / "configs/scenarios/quickstart.yaml").as_data()
    data["tasks"]["axes"] |= {axis: each.as_data() if isinstance(each, Range) else each for axis, each in axes.items()}
    return Scenario.from_data(data, "test")


def labels_of(scenario: Scenario, infeasible: tuple[float, ...]) -> pd.DataFrame:
    """A label for every task, all solved but one; the order of rows says nothing."""
    axes = scenario.tasks.space.columns
    rows = [
        dict(zip(axes, task.on(axes), strict=True))
        | {"split": task.split}
        | {"status": "infeasible" if task.on(scenario.tasks.space.ranged) == infeasible else "solved"}
        for task in tasks_of(scenario)
    ]
    return pd.DataFrame(rows[::-1])


def test_the_domain_is_where_tasks_of_the_grid_were_solved(checkout: Path, tmp_path: Path) -> None:
    scenario = scenario_of(checkout, slope=Range(start=0.0, stop=10.0, count=2))
    ranges = scenario.tasks.ranges
    hole = (ranges["speed"].values[2], ranges["cycle_duration"].values[0], 10.0)
    domain = stages._domain(Workspace(tmp_path).run(scenario), scenario, labels_of(scenario, hole))
    assert tuple(domain.axes) == ("speed", "cycle_duration", "slope")
    assert np.argwhere(~domain.feasible).tolist() == [[2, 0, 1]]


def test_a_fixed_axis_is_none_of_the_domains(checkout: Path, tmp_path: Path) -> None:
    scenario = scenario_of(checkout, cycle_duration=0.6)
    domain = stages._domain(Workspace(tmp_path).run(scenario), scenario, labels_of(scenario, (9.9,)))
    assert dict(domain.axes) == {"speed": scenario.tasks.ranges["speed"].values}
    assert domain.feasible.all()


@pytest.mark.parametrize(
    ("stage", "before"), [("label", "solve"), ("atlas", "label"), ("train", "label"), ("publish", "train")]
)
def test_a_stage_names_the_one_that_has_to_run_first(checkout: Path, tmp_path: Path, stage: str, before: str) -> None:
    scenario = scenario_of(checkout)
    more = {"train": (False,), "publish": (None,)}.get(stage, ())
    with pytest.raises(stages.StageMissing, match=f"run `gaitflow {before} quickstart` first"):
        getattr(stages, stage)(Workspace(tmp_path), scenario, *more)


def test_training_and_publishing_need_the_atlas(checkout: Path, tmp_path: Path) -> None:
    workspace, scenario = Workspace(tmp_path), scenario_of(checkout)
    run = workspace.run(scenario)
    for path in (run.labels, run.learning):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("{}")
    for stage in (lambda: stages.train(workspace, scenario, False), lambda: stages.publish(workspace, scenario, None)):
        with pytest.raises(stages.StageMissing, match="run `gaitflow atlas quickstart` first"):
            stage()


def test_a_summary_counts_tasks_and_the_patterns_of_the_least_symmetric_one(checkout: Path) -> None:
    level = stages.summary(scenario_of(checkout))
    tilted = stages.summary(scenario_of(checkout, slope=Range(start=0.0, stop=10.0, count=2)))
    assert tilted["tasks"] == 2 * (level["tasks"] - 6) + 6
    assert (level["patterns"], tilted["patterns"]) == (24, 36), "on level ground time may run backwards"


def test_numbers_that_do_not_exist_are_null(tmp_path: Path) -> None:
    judged = Predictions(0, 0, *[float("nan")] * 4)
    data = atlas_record(["gallop"], Atlas.empty(["speed"]), 0, judged, 0, 0)
    write_json(tmp_path / "data.json", data)
    assert read_json(tmp_path / "data.json")["predictions"]["iterations_mean"] is None
