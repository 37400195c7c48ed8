"""`gaitflow robot import`: what it writes, prints and refuses."""

from __future__ import annotations

import json
from importlib.metadata import files
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from gaitflow.cli import main
from gaitflow.config.robot import load_robot

ANYMAL = "example-robot-data/robots/anymal_b_simple_description/robots/anymal.urdf"
FEET = "LF_FOOT,RF_FOOT,LH_FOOT,RH_FOOT"


@pytest.fixture(scope="module")
def anymal() -> str:
    return next(str(file.locate()) for file in files("example-robot-data") or () if str(file).endswith(ANYMAL))


def call(root: Path, *words: str) -> Result:
    return CliRunner().invoke(main, ["--root", str(root), "robot", "import", *words])


def test_a_robot_is_written_where_scenarios_find_it(tmp_path: Path, anymal: str) -> None:
    done = call(tmp_path, anymal, "--name", "mine", "--feet", FEET)
    assert done.exit_code == 0, done.stderr
    path = tmp_path / "configs" / "robots" / "mine.yaml"
    assert load_robot(path).name == "mine"
    assert path.read_text().startswith(f"# Made by: gaitflow robot import {ANYMAL} --name mine --feet {FEET}\n")
    assert "made left-right symmetric: feet moved by up to 0.68 mm" in done.stdout
    assert done.stdout.splitlines()[-1] == str(path)
    again = call(tmp_path, anymal, "--name", "mine", "--feet", FEET)
    assert again.exit_code == 2 and f"is there already; to write over it give --output {path}" in again.stderr


def test_a_urdf_of_any_name(tmp_path: Path, anymal: str) -> None:
    path = tmp_path / "two\nlines.urdf"
    path.write_bytes(Path(anymal).read_bytes())
    pose = ",".join(f"{leg}_HAA=0,{leg}_HFE=0.4,{leg}_KFE=-0.8" for leg in ("LF", "RF"))
    pose += "," + ",".join(f"{leg}_HAA=0,{leg}_HFE=-0.4,{leg}_KFE=0.8" for leg in ("LH", "RH"))
    done = call(tmp_path, str(path), "--name", "mine", "--feet", FEET, "--pose", pose)
    assert done.exit_code == 0, done.stderr
    assert load_robot(tmp_path / "configs" / "robots" / "mine.yaml").name == "mine"


def test_json_is_one_document(tmp_path: Path, anymal: str) -> None:
    path = tmp_path / "any.yaml"
    path.write_text("old")
    words = ("--inertia", "base", "--max-tilt", "0.3", "--output", str(path), "--json")
    done = call(tmp_path, anymal, "--name", "mine", "--feet", FEET, *words)
    document = json.loads(done.stdout)
    assert document["path"] == str(path)
    assert document["robot"] == load_robot(path).as_data()
    assert any("base link alone" in said for said in document["found"])
    assert "--inertia base --max-tilt 0.3" in path.read_text().splitlines()[0]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--box", "0.2,0.1,0.1"), "cannot reach its corner"),
        (("--box", "0.2,0.1"), "--box '0.2,0.1': give three half lengths in m"),
        (("--box", "1,nan,1"), "give three half lengths"),
        (("--pose", "dancing"), "no pose 'dancing' (" + ANYMAL.replace("/robots/anymal.urdf", "/srdf/anymal.srdf")),
        (("--srdf", "no.srdf"), "no.srdf: cannot be read"),
        (("--legs", "LF,RF"), "--legs LF,RF has 2"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(
    tmp_path: Path, anymal: str, words: tuple[str, ...], said: str
) -> None:
    done = call(tmp_path, anymal, "--name", "mine", "--feet", FEET, *words)
    assert done.exit_code == 2 and done.stdout == ""
    assert said in done.stderr and len(done.stderr.splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_a_urdf_that_is_not_there(tmp_path: Path) -> None:
    done = call(tmp_path, "no.urdf", "--name", "mine", "--feet", FEET)
    assert done.exit_code == 2 and "no.urdf: cannot be read (No such file or directory)" in done.stderr
