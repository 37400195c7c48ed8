"""Which runs of a sweep the statements are asked of, and what stands beside them for the scenario's own robot."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from gaitflow.config.scenario import Scenario
from gaitflow.config.sweep import Sample, Sweep, sampled
from gaitflow.config.tasks import tasks_of
from gaitflow.dataset.labels_file import read_labels
from gaitflow.dataset.sweep import SAMPLE, write_sweep
from gaitflow.pipeline.sweep import shares_of_robots, sweep_report, sweep_result
from gaitflow.pipeline.workspace import Workspace
from gaitflow.report.claims import EXACT, FIGURES, outcomes

AXES = {"speed": {"start": 0.3, "stop": 0.7, "count": 3}, "cycle_duration": {"start": 0.6, "stop": 1.0, "count": 2}}
SWEEP = Sweep.from_data(
    {"name": "half-cheetah", "samples": 3, "ranges": {"inertia": {"factor": [0.5, 2.0]}}, "axes": AXES}, "test"
)


def rows_of(sample: Sample) -> pd.DataFrame:
    """Walking everywhere."""
    tasks = tasks_of(sample.scenario)
    same = {"split": "grid", "status": "solved", "gait": "walking", "gait_key": "0111/1101"}
    return pd.DataFrame(
        [
            {SAMPLE: sample.number, **sample.values, "speed": task.speed, "cycle_duration": task.cycle_duration}
            | same
            | {"ties": ["walking"]}
            for task in tasks
        ]
    )


def written(workspace: Workspace, name: str, sweep: Sweep) -> Scenario:
    scenario = workspace.scenario(name)
    frame = pd.concat([rows_of(sample) for sample in sampled(scenario, sweep)], ignore_index=True)
    write_sweep(workspace.sweep_run(name, sweep).table, scenario, sweep, frame)
    return scenario


@pytest.fixture
def workspace(tmp_path: Path, checkout: Path) -> Workspace:
    """An empty workspace with the published datasets."""
    (tmp_path / "datasets").symlink_to(checkout / "datasets")
    return Workspace(tmp_path)


def test_statements_are_asked_of_the_figures_that_were_run(workspace: Workspace) -> None:
    written(workspace, EXACT["4a"], SWEEP)
    (rule,) = sweep_result(workspace, SWEEP).rules
    assert rule.name == "exact motion" and "4b-same" not in rule.verdicts
    assert list(rule.verdicts["4a-walking"]) == ["holds"] * 3
    written(workspace, EXACT["4b"], SWEEP)
    written(workspace, FIGURES["4b"], SWEEP)
    result = sweep_result(workspace, SWEEP)
    assert [(rule.name, "4b-same" in rule.verdicts) for rule in result.rules] == [
        ("forward Euler", False),
        ("exact motion", True),
    ]
    assert list(result.parameters["inertia"]) == [one.values["inertia"] for one in sampled_of(workspace)]


def sampled_of(workspace: Workspace) -> tuple[Sample, ...]:
    return sampled(workspace.scenario(EXACT["4a"]), SWEEP)


def test_a_run_of_an_older_file_of_that_name_does_not_count(workspace: Workspace) -> None:
    written(workspace, FIGURES["4a"], SWEEP.model_copy(update={"seed": 1}))
    with pytest.raises(ValueError, match="no finished run of the sweep half-cheetah over a scenario of the paper"):
        sweep_result(workspace, SWEEP)


def test_the_scenarios_own_robot_is_asked_at_the_sweep_s_tasks(workspace: Workspace, checkout: Path) -> None:
    written(workspace, FIGURES["4a"], SWEEP)
    (rule,) = sweep_result(workspace, SWEEP).rules
    newest = sorted((checkout / "datasets" / FIGURES["4a"]).iterdir())[-1]
    labels = read_labels(newest).to_pandas()
    near = labels["speed"].round(9).isin([0.3, 0.5, 0.7]) & labels["cycle_duration"].round(9).isin([0.6, 1.0])
    expected = outcomes({"4a": labels[near & (labels["split"] == "grid")]}, exact=False)
    assert rule.ours == {name: verdict for name, (verdict, _) in expected.items()}
    assert rule.ours != dict(rule.verdicts.loc[0]), "ours does not walk everywhere"


def test_a_task_that_was_not_published_leaves_our_robot_out(workspace: Workspace) -> None:
    axes = AXES | {"cycle_duration": {"start": 0.6, "stop": 0.9, "count": 2}}
    other = Sweep.from_data(SWEEP.as_data() | {"axes": axes}, "test")
    written(workspace, FIGURES["4a"], other)
    assert sweep_result(workspace, other).rules[0].ours == {}


def test_the_document_gives_the_shares_that_stand_beside_the_statements(workspace: Workspace) -> None:
    assert shares_of_robots(workspace) == {}
    written(workspace, FIGURES["4a"], SWEEP)
    page, _, _ = sweep_report(workspace, SWEEP)
    assert shares_of_robots(workspace)["forward Euler"]["4a-walking"] == "3 of 3 (29 to 100 %)"
    assert "| 4a-walking " in page.read_text() and "`half-cheetah-flat-effort`" in page.read_text()
