"""Where scenarios and robots are found: in the workspace, among those that ship, by path."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from gaitflow import shipped
from gaitflow.config.file import ConfigError
from gaitflow.config.scenario import load_scenario
from gaitflow.pipeline.workspace import Workspace

QUICKSTART = shipped.SCENARIOS / "quickstart.yaml"


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """A workspace whose quickstart says that it is its own, and whose half-cheetah weighs 20 kg."""
    for folder, file in (("scenarios", QUICKSTART), ("robots", shipped.ROBOTS / "half_cheetah.yaml")):
        (tmp_path / "configs" / folder).mkdir(parents=True)
        shutil.copy(file, tmp_path / "configs" / folder)
    change(tmp_path / "configs/scenarios/quickstart.yaml", "A small map", "Our small map")
    change(tmp_path / "configs/robots/half_cheetah.yaml", "mass: 14.0", "mass: 20.0")
    return tmp_path


def change(file: Path, old: str, new: str) -> None:
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new), encoding="utf-8")


def test_what_ships_is_found_by_name_from_an_empty_folder(tmp_path: Path) -> None:
    for file in shipped.SCENARIOS.glob("*.yaml"):
        assert Workspace(tmp_path).scenario(file.stem) == load_scenario(file)


def test_the_workspace_s_own_files_come_first(own: Path) -> None:
    scenario = Workspace(own).scenario("quickstart")
    assert scenario.description.startswith("Our small map") and scenario.robot.mass == 20.0
    assert Workspace(own).scenario("half-cheetah-exact-slopes").robot.mass == 20.0, "also of a scenario that ships"


def test_a_scenario_by_path_may_lie_anywhere(own: Path, tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    assert Workspace(elsewhere).scenario(str(own / "configs/scenarios/quickstart.yaml")).robot.mass == 20.0


@pytest.mark.parametrize("name", ["quickstrat", "half-cheetah-exact-slope"])
def test_an_unknown_name_suggests_the_nearest(name: str, tmp_path: Path) -> None:
    nearest = {"quickstrat": "quickstart", "half-cheetah-exact-slope": "half-cheetah-exact-slopes"}[name]
    with pytest.raises(ConfigError, match=f"scenario '{name}': .* ships, did you mean {nearest}\\? there are anymal-"):
        Workspace(tmp_path).scenario(name)


def test_a_file_is_called_as_its_scenario(own: Path) -> None:
    (own / "configs/scenarios/quickstart.yaml").rename(own / "configs/scenarios/mine.yaml")
    with pytest.raises(ConfigError, match=r"mine\.yaml: name = 'quickstart': must be 'mine'"):
        Workspace(own).scenario("mine")
