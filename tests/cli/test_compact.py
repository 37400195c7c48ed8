from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from gaitflow.cli import main
from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.execute.status import run_status
from gaitflow.search.solution import Solution
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit, plan_units


def rows_of(unit: Unit) -> list[Solution]:
    return [
        Solution(
            task=task, pattern="0110/1100",
            gait="0110/1100", strategy="patterns", start="nominal", seed=0, status="infeasible", solver_status="",
            cost=float("nan"), violation=float("nan"), iterations=1, solves=1, wall_s=0.0, cpu_s=0.0,
        )
        for task in unit.tasks
    ]  # fmt: skip


@pytest.fixture
def project(checkout: Path, tmp_path: Path) -> Path:
    shutil.copytree(checkout / "configs", tmp_path / "configs")
    return tmp_path


@pytest.fixture
def scenario(project: Path) -> Scenario:
    return load_scenario(project / "configs/scenarios/quickstart.yaml")


@pytest.fixture
def store(project: Path, scenario: Scenario) -> UnitStore:
    store = UnitStore(project / "runs" / "quickstart")
    for unit in plan_units(scenario):
        store.write(unit, rows_of(unit), {})
    return store


def ask(project: Path, *arguments: str) -> Result:
    return CliRunner().invoke(main, ["--root", str(project), "compact", *arguments])


def test_all_small_files_become_one_and_the_run_is_still_done(
    project: Path, scenario: Scenario, store: UnitStore
) -> None:
    done = ask(project, "quickstart")
    assert done.exit_code == 0 and "quickstart: 5 part(s) moved into 1 pack(s)" in done.output
    assert not list((store.folder / "units").rglob("*.parquet"))
    status = run_status(scenario, UnitStore(store.folder))
    assert (status.solved, status.left) == (5, 0)
    again = ask(project, "quickstart", "--json")
    assert json.loads(again.output) == {"parts": 0, "packs": 0, "bytes": 0, "damaged": {}}


def test_damaged_parts_are_told_and_fail(project: Path, store: UnitStore) -> None:
    part = next((store.folder / "units").rglob("*.parquet"))
    part.write_bytes(part.read_bytes()[:-1])
    done = ask(project, "quickstart")
    assert done.exit_code == 1 and "4 part(s) moved into 1 pack(s)" in done.output
    assert "1 damaged part(s) have to be solved again: gaitflow solve quickstart" in done.output
    assert part.stem in done.output


def test_a_scenario_that_never_ran_has_nothing_to_move(project: Path) -> None:
    done = ask(project, "quickstart")
    assert done.exit_code == 0 and "0 part(s)" in done.output and not (project / "runs").exists()
    assert ask(project, "no-such-scenario").exit_code == 2
