"""`gaitflow show` on a published planar dataset and on a small one of ANYmal."""

from __future__ import annotations

import json
from pathlib import Path

import matplotlib.image
import pytest
from click.testing import CliRunner, Result

from gaitflow.cli import main
from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.dataset.collect import collect
from gaitflow.search import solve_tasks
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import plan_units

PATTERN = "0111/1101/1101/0111"


def ask(*arguments: object) -> Result:
    return CliRunner().invoke(main, ["show", *map(str, arguments)])


@pytest.fixture(scope="module")
def planar(checkout: Path) -> Path:
    return checkout / "datasets/half-cheetah-flat-effort/1.0.0"


@pytest.fixture(scope="module")
def spatial(checkout: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A collected dataset of two tasks of ANYmal's walking trot with 4 knots a phase."""
    data = load_scenario(checkout / "tests/data/scenarios/anymal-flat-vibration.yaml").as_data()
    data["transcription"]["knots_per_phase"] = 4
    axes = data["tasks"]["axes"]
    axes["speed"] = {"start": 0.2, "stop": 0.4, "count": 2}
    axes["cycle_duration"] = {"start": 0.8, "stop": 0.8, "count": 1}
    data["strategy"] = {"name": "fixed_gait", "pattern": PATTERN}
    scenario = Scenario.from_data(data, "test")
    store = UnitStore(tmp_path_factory.mktemp("runs") / scenario.name)
    for unit in plan_units(scenario):
        store.write(unit, solve_tasks(unit.scenario, unit.tasks), {})
    return collect(store, scenario).parent


def test_without_a_file_to_write_it_lists_the_gaits_of_the_nearest_task(planar: Path) -> None:
    answer = ask(planar, "--speed", 1.0, "--cycle", 0.62, "--json")
    assert answer.exit_code == 0, answer.output
    data = json.loads(answer.stdout)
    assert data["speed"] == pytest.approx(1.0, abs=0.1) and data["cycle_duration"] == pytest.approx(0.62, abs=0.1)
    assert [one["rank"] for one in data["gaits"]] == list(range(1, len(data["gaits"]) + 1))
    assert data["files"] == []
    lines = ask(planar, "--speed", 1.0, "--cycle", 0.62).stdout.splitlines()
    assert lines[0].startswith(f"nearest stored task: speed {data['speed']:g} m/s") and "(asked: 1, 0.62)" in lines[0]
    assert [line.split()[0] for line in lines[1:]] == [str(one["rank"]) for one in data["gaits"]]


@pytest.mark.parametrize("choice", [["--rank", "2"], ["--gait", "gallop-walk"], []])
def test_it_draws_a_planar_motion(planar: Path, tmp_path: Path, choice: list[str]) -> None:
    page, strip = tmp_path / "new" / "motion.html", tmp_path / "motion.png"
    answer = ask(planar, "--speed", 1, "--cycle", 0.62, *choice, "--output", page, "--strip", strip, "--json")
    assert answer.exit_code == 0, answer.output
    data = json.loads(answer.stdout)
    (drawn,) = data["gaits"]
    assert data["files"] == [str(page), str(strip)]
    assert f"<h1>{drawn['gait']}</h1>" in page.read_text(encoding="utf-8")
    assert drawn["pattern"] in page.read_text(encoding="utf-8")
    assert matplotlib.image.imread(strip).shape[1] > 1000


def test_it_draws_a_motion_in_space_from_a_run(spatial: Path, tmp_path: Path) -> None:
    page, strip = tmp_path / "motion.html", tmp_path / "motion.png"
    answer = ask(spatial, "--speed", 0.38, "--cycle", 0.7, "--output", page, "--strip", strip)
    assert answer.exit_code == 0, answer.output
    assert (
        answer.stdout.splitlines()[0] == "nearest stored task: speed 0.4 m/s, cycle_duration 0.8 s (asked: 0.38, 0.7)"
    )
    assert "walking trot" in answer.stdout
    html = page.read_text(encoding="utf-8")
    assert "<h1>walking trot</h1>" in html and PATTERN in html and "NOT feasible" not in html
    assert len(html) < 1_000_000
    assert matplotlib.image.imread(strip).shape[1] > 1000


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--speed", "nan", "--cycle", "0.6"], "speed = nan m/s: must lie in -20 to 20 m/s"),
        (["--speed", "21", "--cycle", "0.6"], "speed = 21 m/s: must lie in -20 to 20 m/s"),
        (["--speed", "1", "--cycle", "0.6", "--speed", "2"], "--speed is given 2 times"),
        (["--speed", "1", "--cycle", "0.6", "--slope", "4"], "slope = 4: it is fixed at 0 deg here"),
        (["--speed", "1", "--cycle", "0.6", "--gait", "moonwalk"], "gait 'moonwalk': not among"),
        (["--speed", "1", "--cycle", "0.6", "--rank", "9"], "rank 9: only its cost was stored"),
        (["--speed", "1", "--cycle", "0.6", "--rank", "1", "--gait", "gallop"], "not both"),
        (["--speed", "1"], "needs cycle_duration as well"),
    ],
)
def test_what_cannot_be_shown_is_one_clear_line(planar: Path, arguments: list[str], says: str) -> None:
    answer = ask(planar, *arguments)
    assert answer.exit_code == 2 and says in answer.stderr
    assert "Traceback" not in answer.output


def test_a_folder_without_a_dataset_and_a_folder_that_cannot_be_written(planar: Path, tmp_path: Path) -> None:
    empty = ask(tmp_path, "--speed", 1, "--cycle", 0.6)
    assert empty.exit_code == 2 and "holds neither a map nor a dataset" in empty.stderr
    (tmp_path / "file").write_text("")
    refused = ask(planar, "--speed", 1, "--cycle", 0.6, "--output", tmp_path / "file" / "motion.html")
    assert refused.exit_code == 1 and "motion.html" in refused.stderr


def test_help_has_an_example() -> None:
    assert "Example: gaitflow show " in ask("--help").stdout


def test_one_file_cannot_be_both(planar: Path, tmp_path: Path) -> None:
    asked = "--speed", 0.9, "--cycle", 0.6, "--output", tmp_path / "motion", "--strip", tmp_path / "." / "motion"
    answer = ask(planar, *asked)
    assert answer.exit_code == 2
    assert "overwrite" in answer.output
    assert not (tmp_path / "motion").exists()
