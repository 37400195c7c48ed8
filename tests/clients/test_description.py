from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitflow.clients.description import describe
from gaitflow.config.file import ConfigError
from gaitflow.runtime import GaitMap

MAPS = ("anymal-exact-vibration", "go1-exact-vibration")


def scenario_of(checkout: Path, name: str) -> Mapping[str, Any]:
    return GaitMap.load(checkout / "models" / name).manifest.scenario


@pytest.mark.parametrize("name", MAPS)
def test_installed_urdf_is_found_and_stands_on_the_contact_points(checkout: Path, name: str) -> None:
    robot = describe(scenario_of(checkout, name))
    assert [foot.link for foot in robot.feet] == [foot.link for foot in robot.frames.feet]
    for foot, frame in zip(robot.feet, robot.frames.feet, strict=True):
        assert np.linalg.norm(np.array(frame.contact_point) - foot.centre) == pytest.approx(foot.radius, abs=1e-5)
    assert robot.depth == pytest.approx({"anymal": 0.0089, "go1": 0.02}[name.split("-")[0]], abs=1e-4)


def test_path_that_is_given_is_read_instead(checkout: Path, tmp_path: Path) -> None:
    scenario = scenario_of(checkout, MAPS[0])
    found = describe(scenario).urdf
    (tmp_path / "mine.urdf").write_text(found.text)
    pose = ",".join(f"{name}={value}" for name, value in describe(scenario).pose.items())
    robot = dict(scenario["robot"], source=f"mine.urdf, pose {pose}, base level; by hand")
    assert describe({**scenario, "robot": robot}, tmp_path / "mine.urdf").urdf.path.name == "mine.urdf"


def test_urdf_of_another_robot_is_one_line(checkout: Path) -> None:
    go1 = describe(scenario_of(checkout, MAPS[1])).urdf.path
    with pytest.raises(ConfigError, match="a URDF whose feet do not match") as error:
        describe(scenario_of(checkout, MAPS[0]), go1)
    assert "\n" not in str(error.value)


def test_feet_elsewhere_or_another_mass_are_refused(checkout: Path, tmp_path: Path) -> None:
    scenario = scenario_of(checkout, MAPS[0])
    urdf = describe(scenario).urdf.path
    robot = dict(scenario["robot"], legs=[dict(leg) for leg in scenario["robot"]["legs"]])
    robot["legs"][0]["default_foot"] = [0.4, 0.2, -0.46]
    with pytest.raises(ConfigError, match="feet do not match"):
        describe({**scenario, "robot": robot}, urdf)
    with pytest.raises(ConfigError, match=r"weighs 30\.475 kg, the map's robot anymal 40\.000 kg"):
        describe({**scenario, "robot": {**scenario["robot"], "mass": 40.0}}, urdf)


def test_robot_that_does_not_say_where_it_comes_from_needs_a_path(checkout: Path) -> None:
    scenario = scenario_of(checkout, MAPS[0])
    with pytest.raises(ConfigError, match="--urdf"):
        describe({**scenario, "robot": {**scenario["robot"], "source": "measured"}})
    with pytest.raises(ConfigError, match=r"example-robot-data/robots/no\.urdf"):
        describe({**scenario, "robot": {**scenario["robot"], "source": "example-robot-data/robots/no.urdf, pose x"}})


def test_robot_without_frames_has_to_be_imported_again(checkout: Path) -> None:
    scenario = scenario_of(checkout, "half-cheetah-exact-vibration")
    with pytest.raises(ConfigError, match="gaitflow robot import"):
        describe(scenario)
