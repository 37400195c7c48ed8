"""Commands on published folders: of one version or of several, of a map or its dataset, and on what is neither."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from gaitflow.cli import main
from gaitflow.runtime import GaitMap

NAME = "half-cheetah-exact-vibration"
TASK = ("--speed", "0.9", "--cycle", "0.6")


def call(root: Path, *arguments: object) -> Result:
    return CliRunner().invoke(main, ["--root", str(root), *map(str, arguments)])


@pytest.fixture(scope="module")
def alone(checkout: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A map without the dataset that it was learnt from."""
    folder = tmp_path_factory.mktemp("elsewhere") / "models" / NAME
    return Path(shutil.copytree(checkout / "models" / NAME, folder))


@pytest.mark.parametrize("command", [("labels",), ("show", *TASK), ("verify",)])
@pytest.mark.parametrize("kind", ["datasets", "models"])
def test_a_folder_of_versions_means_the_newest(checkout: Path, command: tuple[str, ...], kind: str) -> None:
    folder = checkout / kind / NAME
    whole = call(checkout, command[0], folder, *command[1:], "--json")
    one = call(checkout, command[0], folder / "1.1.0", *command[1:], "--json")
    assert whole.exit_code == 0, whole.output
    assert whole.stdout.replace(str(folder), "") == one.stdout.replace(str(folder / "1.1.0"), "")


def test_the_labels_of_a_map_are_those_it_was_learnt_from(checkout: Path) -> None:
    found = [call(checkout, "labels", checkout / kind / NAME, "--json").stdout for kind in ("models", "datasets")]
    assert found[0] == found[1] and len(json.loads(found[0])) == 124


def test_a_map_alone_predicts_labels_on_its_grid(alone: Path, tmp_path: Path) -> None:
    rows, gait_map = json.loads(call(tmp_path, "labels", alone, "--json").stdout), GaitMap.load(alone)
    assert len(rows) == gait_map.manifest.domain.feasible.size
    for row in rows:
        assert row["gait"] == gait_map.select(row["speed"], row["cycle_duration"]).gait
        assert row["cost"] > 0 and row["ties"][0] == row["gait"] != row["runner_up"] and row["resolved"] is False


def test_a_report_is_drawn_from_published_folders(checkout: Path, alone: Path, tmp_path: Path) -> None:
    done = call(checkout, "report", checkout / "models" / NAME, "--output", tmp_path / "map", "--json")
    assert done.exit_code == 0, done.output
    assert {Path(path).name for path in json.loads(done.stdout)} >= {"index.html", "map.png", "motion-gallop.png"}
    page = (tmp_path / "map" / "index.html").read_text()
    assert "Provenance" in page and "Classifiers" in page
    done = call(tmp_path, "report", alone)
    page = (tmp_path / "runs" / NAME / "report-1.1.0" / "index.html").read_text()
    assert done.exit_code == 0 and "Drawn from the map alone" in page and "Provenance" not in page
    files = [{path.name for path in (each / "1.1.0").iterdir()} for each in (alone, checkout / "models" / NAME)]
    assert files[0] == files[1], "nothing is written where it was published"
    stray = call(checkout, "report", "quickstart", "--output", tmp_path)
    assert stray.exit_code == 2 and "quickstart is no folder of a map or dataset" in stray.stderr


def test_a_map_shows_what_it_plans(alone: Path, tmp_path: Path) -> None:
    done = call(tmp_path, "show", alone, *TASK, "--rank", "2", "--output", tmp_path / "motion.html", "--json")
    assert done.exit_code == 0, done.output
    found, gait_map = json.loads(done.stdout), GaitMap.load(alone)
    assert (found["speed"], found["cycle_duration"]) == (0.9, 0.6)
    gait = found["gaits"][0]["gait"]
    assert gait != gait_map.select(0.9, 0.6).gait and (tmp_path / "motion.html").exists()
    assert found["gaits"][0]["cost"] == pytest.approx(gait_map.plan(0.9, 0.6, gait=gait).cost, rel=0.1)
    far = call(tmp_path, "show", alone, "--speed", "9", "--cycle", "0.6")
    assert far.exit_code == 2 and "speed = 9 m/s is outside the map's" in far.stderr


def test_a_map_draws_the_gait_that_it_plans(checkout: Path, tmp_path: Path) -> None:
    version, task = checkout / "models/half-cheetah-exact-slopes/1.2.0", (0.75, 3.44, 1.32)
    asked = dict(zip(("cycle_duration", "slope", "speed"), task, strict=True))
    gait_map, options = GaitMap.load(version), ("--cycle", task[0], "--slope", task[1], "--speed", task[2])
    planned, target = gait_map.plan(**asked), tmp_path / "motion.html"
    assert planned.gait != gait_map.select(**asked).gait, "another gait came out cheaper than predicted"
    done = call(tmp_path, "show", version, *options, "--output", target, "--json")
    assert done.exit_code == 0, done.output
    assert [one["gait"] for one in json.loads(done.stdout)["gaits"]] == [planned.gait] and target.exists()
    listed = json.loads(call(tmp_path, "show", version, *options, "--json").stdout)["gaits"]
    assert listed[0]["gait"] != planned.gait, "the list is by predicted cost"


@pytest.mark.parametrize("command", ["labels", "show", "verify", "trace", "plan", "export"])
@pytest.mark.parametrize("there", ["nowhere", "empty", "file"])
def test_what_is_nothing_of_ours_is_one_line(tmp_path: Path, command: str, there: str) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "file").write_text("text")
    more = {"show": TASK, "plan": TASK, "export": ("--c", tmp_path / "out")}.get(command, ())
    done = call(tmp_path, command, tmp_path / there, *more)
    assert done.exit_code == 2 and str(tmp_path / there) in done.stderr and len(done.stderr.splitlines()) == 1


def test_a_dataset_is_no_map_and_says_so(checkout: Path) -> None:
    done = call(checkout, "plan", checkout / "datasets" / NAME, *TASK)
    assert done.exit_code == 2 and "is a dataset, not a map; give a map's folder" in done.stderr


def test_a_missing_root_is_one_line(tmp_path: Path) -> None:
    done = call(tmp_path / "nowhere", "status", "quickstart")
    assert done.exit_code == 2 and done.stderr == f"gaitflow: --root {tmp_path}/nowhere: no such folder; " + (
        "give the one with configs/\n"
    )


def test_a_file_in_the_place_of_a_folder_is_one_line(checkout: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    target = tmp_path / "file" / "motion.html"
    done = call(checkout, "show", checkout / "datasets" / NAME, *TASK, "--output", target)
    assert done.exit_code == 1 and f"{target}: cannot be written" in done.stderr and "choose another" in done.stderr
    assert "Errno" not in done.stderr and len(done.stderr.splitlines()) == 1
