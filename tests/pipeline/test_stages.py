"""What stages hand on, and what they say when the stage before is missing."""

from __future__ import annotations

from pathlib import Path

import pytest

from gaitflow.atlas.judge import Predictions
from gaitflow.config.file import ConfigError
from gaitflow.config.scenario import Range, Scenario, load_scenario
from gaitflow.learn import installed
from gaitflow.pipeline import stages
from gaitflow.pipeline.atlas_record import atlas_record
from gaitflow.pipeline.earlier import StageMissing
from gaitflow.pipeline.json_file import read_json, write_json
from gaitflow.pipeline.workspace import Workspace
from gaitflow.runtime.atlas import Atlas


def scenario_of(checkout: Path, **axes: Range | float) -> Scenario:
    data = load_scenario(checkout / "configs/scenarios/quickstart.yaml").as_data()
    data["tasks"]["axes"] |= {axis: each.as_data() if isinstance(each, Range) else each for axis, each in axes.items()}
    return Scenario.from_data(data, "test")


@pytest.mark.parametrize(
    ("stage", "before"), [("label", "solve"), ("atlas", "label"), ("train", "label"), ("publish", "train")]
)
def test_a_stage_names_the_one_that_has_to_run_first(checkout: Path, tmp_path: Path, stage: str, before: str) -> None:
    scenario = scenario_of(checkout)
    more = {"train": (False,), "publish": (None,)}.get(stage, ())
    with pytest.raises(StageMissing, match=f"run `gaitflow {before} quickstart` first"):
        getattr(stages, stage)(Workspace(tmp_path), scenario, *more)


def test_training_and_publishing_need_the_atlas(checkout: Path, tmp_path: Path) -> None:
    workspace, scenario = Workspace(tmp_path), scenario_of(checkout)
    run = workspace.run(scenario)
    for path in (run.labels, run.learning):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("{}")
    for stage in (lambda: stages.train(workspace, scenario, False), lambda: stages.publish(workspace, scenario, None)):
        with pytest.raises(StageMissing, match="run `gaitflow atlas quickstart` first"):
            stage()


def test_a_sampling_whose_classifier_cannot_be_trained_here_searches_nothing(
    checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(installed, "find_spec", lambda _: None)
    workspace, scenario = Workspace(tmp_path), load_scenario(checkout / "configs/scenarios/anymal-exact-vibration.yaml")
    with pytest.raises(ConfigError, match="needs PyTorch"):
        stages.solve(workspace, scenario, 1)
    assert not list(workspace.run(scenario).folder.rglob("*.parquet"))


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
