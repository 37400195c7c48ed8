"""The robots that are shipped, made again by the commands they name, and what a URDF may not be."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from gaitflow.cli import main
from gaitflow.config.file import ConfigError
from gaitflow.config.limbs import Limb
from gaitflow.config.robot import Robot, load_robot
from gaitflow.urdf.importing import Request, import_robot

CONFIGS = Path(__file__).parents[2] / "configs" / "robots"
MADE_BY = "# Made by: gaitflow "
IMPORTED = [path for path in sorted(CONFIGS.glob("*.yaml")) if path.read_text().startswith(MADE_BY)]
Write = Callable[..., Path]


def numbers(robot: Robot) -> list[float]:
    feet = [value for leg in robot.legs for value in leg.default_foot]
    inertia = [value for row in robot.inertia for value in row]
    return [robot.mass, *inertia, *feet, *robot.box, robot.max_force, robot.max_foot_speed, robot.max_tilt]


def lengths(limb: Limb) -> list[float]:
    inertia = [value for row in limb.flexion_inertia for value in row]
    return [*limb.hip, limb.aside, limb.below, limb.thigh, limb.shank, limb.abduction_inertia, *inertia]


def test_the_robots_of_the_issue_are_there() -> None:
    assert {path.stem for path in IMPORTED} >= {"anymal", "anymal_b", "anymal_c", "hyq", "solo12", "go1"}


@pytest.mark.parametrize("path", IMPORTED, ids=lambda path: path.stem)
def test_the_command_in_a_file_makes_that_file(
    path: Path, tmp_path: Path, example_robot: Callable[[str], Path]
) -> None:
    words = shlex.split(path.read_text().splitlines()[0].removeprefix(MADE_BY))
    words[2] = str(example_robot(words[2]))
    done = CliRunner().invoke(main, [*words, "--output", str(tmp_path / "again.yaml")])
    assert done.exit_code == 0, done.output
    again, shipped = load_robot(tmp_path / "again.yaml"), load_robot(path)
    np.testing.assert_allclose(numbers(again), numbers(shipped), atol=1.01e-6, rtol=0)
    assert (again.name, again.leg_names, again.mirror) == (shipped.name, shipped.leg_names, shipped.mirror)
    assert again.frames is not None and shipped.frames is not None
    assert again.frames.base_link == shipped.frames.base_link
    np.testing.assert_allclose(again.frames.com_in_base, shipped.frames.com_in_base, atol=1.01e-6, rtol=0)
    for one, other in zip(again.frames.feet, shipped.frames.feet, strict=True):
        assert (one.leg, one.link) == (other.leg, other.link)
        np.testing.assert_allclose(one.contact_point, other.contact_point, atol=1.01e-6, rtol=0)
    for limb, shipped_limb in zip(again.limbs or (), shipped.limbs or (), strict=True):
        assert (limb.leg, limb.knee) == (shipped_limb.leg, shipped_limb.knee)
        np.testing.assert_allclose(lengths(limb), lengths(shipped_limb), atol=2.01e-6, rtol=0)
    assert (tmp_path / "again.yaml").read_text().splitlines()[0] == path.read_text().splitlines()[0]


def test_the_papers_anymal_is_anymal_b_with_other_limits() -> None:
    paper, urdf = load_robot(CONFIGS / "anymal.yaml"), load_robot(CONFIGS / "anymal_b.yaml")
    assert (paper.mass, paper.inertia, paper.legs, paper.box) == (urdf.mass, urdf.inertia, urdf.legs, urdf.box)
    assert (paper.max_force, paper.max_foot_speed) == (500.0, 2.5)
    assert urdf.max_force == pytest.approx(422, abs=0.5)


@pytest.fixture
def request_(write: Write, by_hand: Any) -> Request:
    return Request(
        write(by_hand.text()), "walker", by_hand.feet, pose=by_hand.standing, max_force=200.0, box=(0.05, 0.05, 0.02)
    )


def test_a_robot_worked_out_by_hand(request_: Request, by_hand: Any) -> None:
    imported = import_robot(request_)
    robot = imported.robot
    height = (by_hand.thigh + by_hand.shank) * np.cos(0.5) * 20 / 22  # the centre of mass hangs 1/11 lower
    expected = [by_hand.hip[0], by_hand.hip[1] + by_hand.offset, -height]
    np.testing.assert_allclose(robot.legs[0].default_foot, expected, atol=1e-6)
    assert robot.mirror == (("LF", "RF"), ("LH", "RH"))
    assert robot.mass == 22.0
    assert robot.source == "; ".join(imported.found)


def test_the_inertia_of_the_base_is_a_choice_that_is_said(request_: Request) -> None:
    composite, base = import_robot(request_), import_robot(replace(request_, inertia="base"))
    assert base.robot.inertia == ((0.3, 0.0, 0.0), (0.0, 0.8, 0.0), (0.0, 0.0, 0.9))
    assert composite.robot.inertia[1][1] > 0.8
    assert "inertia of the base link alone" in base.robot.source
    assert "inertia of the whole robot" in composite.robot.source


def test_what_was_off_is_said_and_evened(write: Write, by_hand: Any, request_: Request) -> None:
    lopsided = by_hand.text().replace('xyz="0.3 0.1 0.0"', 'xyz="0.3 0.104 0.0"')  # LF's hip 4 mm outwards
    imported = import_robot(replace(request_, urdf=write(lopsided, "lopsided.urdf")))
    left, right = (np.array(leg.default_foot) for leg in imported.robot.legs[:2])
    np.testing.assert_array_equal(left, right * [1, -1, 1])
    assert any("feet moved by up to 1." in said and "Iyz = " in said for said in imported.found)


def test_limits_and_names_as_asked_for(request_: Request) -> None:
    asked = replace(request_, legs=("A", "B", "C", "D"), max_foot_speed=1.5, max_tilt=0.3)
    robot = import_robot(asked).robot
    assert robot.leg_names == ("A", "B", "C", "D")
    assert (robot.max_force, robot.max_foot_speed, robot.max_tilt, robot.box) == (200.0, 1.5, 0.3, (0.05, 0.05, 0.02))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"feet": ("LF_foot", "LF_foot", "LH_foot", "RH_foot")}, "each link once"),
        ({"feet": ("LF_foot", "RF_foot")}, "--feet names 2 links, --legs LF,RF,LH,RH has 4"),
        ({"feet": ("RF_foot", "LF_foot", "LH_foot", "RH_foot")}, "foot RF_foot is at .* which is no place for leg LF"),
        ({"feet": ("LF_foot", "RF_foot", "LH_foot", "RH_toe")}, "no link 'RH_toe'; it has RH_foot"),
        ({"name": "Walker"}, "robot Walker: name = 'Walker': String should match"),
        ({"box": (0.2, 0.1, 0.1)}, "leg .. cannot reach its corner"),
        ({"max_force": -1.0}, "max_force = -1.0: Input should be greater than 0"),
        ({"pose": None}, "which pose"),
        ({"srdf": Path("missing.srdf")}, "missing.srdf: cannot be read"),
    ],
)
def test_what_cannot_be_imported(request_: Request, change: dict[str, Any], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        import_robot(replace(request_, **change))


@pytest.mark.parametrize("legs", [("FL", "FR", "RL", "RR"), ("LF", "RF", "LH", "RH"), ("FL", "FR", "HL", "HR")])
def test_front_and_hind_swapped_are_found_however_legs_are_spelt(request_: Request, legs: tuple[str, ...]) -> None:
    assert import_robot(replace(request_, legs=legs)).robot.leg_names == legs
    swapped = replace(request_, legs=legs, feet=("LH_foot", "RH_foot", "LF_foot", "RF_foot"))
    with pytest.raises(ConfigError, match=f"foot LH_foot is at .* which is no place for leg {legs[0]}"):
        import_robot(swapped)
    mirrored = replace(request_, legs=legs, feet=("RF_foot", "LF_foot", "RH_foot", "LH_foot"))
    with pytest.raises(ConfigError, match=f"foot RF_foot is at .* which is no place for leg {legs[0]}"):
        import_robot(mirrored)


def test_a_right_leg_is_no_rear_left_one(request_: Request) -> None:
    """RL tells a place only where another leg is a front one."""
    names = ("LL", "RL", "LA", "RA")
    assert import_robot(replace(request_, legs=names)).robot.leg_names == names


def test_a_robot_on_its_back(request_: Request, by_hand: Any) -> None:
    turned = by_hand.standing.replace("HAA=0", "HAA=3.14159")
    with pytest.raises(ConfigError, match="not below it: the base link's z must point up"):
        import_robot(replace(request_, pose=turned))


@pytest.mark.parametrize("text", ['<robot name="stranger"/>', "<robot", '<robot name="walker"><group_state/></robot>'])
def test_a_pose_written_out_needs_no_srdf(request_: Request, text: str) -> None:
    """So one that lies beside the URDF, broken or another robot's, cannot stop the import."""
    before = import_robot(request_)
    for name in ("a.srdf", "b.srdf"):
        request_.urdf.with_name(name).write_text(text)
    assert import_robot(request_) == before


def scaled(urdf: str, factor: float) -> str:
    def times(match: re.Match[str]) -> str:
        return 'xyz="' + " ".join(str(float(value) * factor) for value in match[1].split()) + '"'

    return re.sub(r'(?<=<origin )xyz="([^"]*)"', times, urdf)


@pytest.mark.parametrize(("factor", "said"), [(1000, "500 m"), (0.05, "0.025 m")])
def test_a_urdf_in_other_units_than_metres_is_refused(
    write: Write, by_hand: Any, request_: Request, factor: float, said: str
) -> None:
    import_robot(replace(request_, urdf=write(scaled(by_hand.text(), 1.0), "same.urdf")))
    with pytest.raises(ConfigError, match=rf"leg LF reaches {said} from .*_HFE.*: a URDF is in metres"):
        import_robot(replace(request_, urdf=write(scaled(by_hand.text(), factor), "scaled.urdf"), box=None))


def test_feet_that_cannot_hold_the_weight_are_told(request_: Request) -> None:
    weight = 22.0 * 9.81
    enough, less = (replace(request_, max_force=part * weight / 4) for part in (1.01, 0.99))
    assert not any("cannot stand" in said for said in import_robot(enough).found)
    (said,) = (said for said in import_robot(less).found if "cannot stand" in said)
    assert "4 feet hold 214 N together, less than its weight of 216 N" in said
    assert said in import_robot(less).robot.source
