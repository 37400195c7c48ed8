from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.child import Child, Lost
from benchmarks.paper.bonmin_log import read_log
from benchmarks.search.search import bonmin
from gaitflow.config.scenario import Scenario
from gaitflow.problem import transcribe


@pytest.fixture(scope="module")
def small(scenario: Scenario) -> Scenario:
    """Three phases of three knots, which Bonmin searches whole in seconds."""
    return scenario.model_copy(
        update={"transcription": scenario.transcription.model_copy(update={"phases": 3, "knots_per_phase": 3})}
    )


def test_the_log_and_the_result_agree(small: Scenario, tmp_path: Path) -> None:
    setup = {"scenario": bonmin(small, 60.0).as_data(), "log": str(tmp_path / "log")}
    with Child("benchmarks.search.logged_search:LoggedSearch", setup) as child:
        found = child.call(90.0, task={"speed": 2.0, "cycle_duration": 0.6}, seed=0)
    log = read_log((tmp_path / "log").read_text(encoding="utf-8"))
    assert log.completed and log.nodes > 5
    assert log.best is not None and found["status"] == "solved"
    assert log.best * transcribe(small).cost_scale == pytest.approx(found["cost"], rel=1e-5)
    assert [path.name for path in tmp_path.iterdir()] == ["log"], "the options file is elsewhere, and gone"


def test_a_killed_run_leaves_its_log(scenario: Scenario, tmp_path: Path) -> None:
    setup = {"scenario": bonmin(scenario, 60.0).as_data(), "log": str(tmp_path / "log")}
    with Child("benchmarks.search.logged_search:LoggedSearch", setup) as child, pytest.raises(Lost, match="hung"):
        child.call(10.0, task={"speed": 1.3, "cycle_duration": 0.6}, seed=0)
    log = read_log((tmp_path / "log").read_text(encoding="utf-8"))
    assert log.programs > 5
    assert not log.completed
