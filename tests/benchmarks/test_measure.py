"""The benches by name: which files they read for a scenario whose map chooses its tasks."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from benchmarks.measure import measure
from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.pipeline.earlier import StageMissing
from gaitflow.pipeline.workspace import Workspace

NAME = "half-cheetah-slope20-vibration"


@pytest.fixture
def chosen(checkout: Path) -> Scenario:
    scenario = load_scenario(checkout / f"configs/scenarios/{NAME}.yaml")
    assert scenario.tasks.adaptive is not None
    return scenario


def test_labels_of_a_grid_are_the_newest_published_ones(checkout: Path, chosen: Scenario, tmp_path: Path) -> None:
    shutil.copytree(checkout / "datasets" / NAME, tmp_path / "datasets" / NAME)
    done = measure("certificate", Workspace(tmp_path), chosen, tasks=1, seed=0)
    assert done["summary"]["tasks"] == 1
    (row,) = done["rows"]
    assert row["speed"] in chosen.tasks.ranges["speed"].values, "a task of the grid, which has a label"


def test_without_one_the_bench_says_what_to_do(chosen: Scenario, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=f"{NAME}: its map chooses its tasks and no dataset .* has a grid"):
        measure("certificate", Workspace(tmp_path), chosen, tasks=1, seed=0)


def test_a_run_without_labels_is_told_by_its_command(scenario: Scenario, tmp_path: Path) -> None:
    with pytest.raises(StageMissing, match=f"labels.parquet is missing: run `gaitflow label {scenario.name}` first"):
        measure("certificate", Workspace(tmp_path), scenario, tasks=1, seed=0)
