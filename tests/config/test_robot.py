"""What a robot file may say, and what is said of one that may not."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from pydantic import ValidationError
from scipy.spatial.transform import Rotation

from gaitflow.config.file import ConfigError
from gaitflow.config.robot import Robot, load_robot

CONFIGS = Path(__file__).parents[2] / "configs" / "robots"


@pytest.fixture
def planar() -> dict[str, Any]:
    """A hopper with two legs in the plane."""
    return {
        "name": "hopper",
        "dimension": 2,
        "mass": 14,
        "inertia": [[1.2]],
        "legs": [{"name": "F", "default_foot": [0.5, -0.5]}, {"name": "H", "default_foot": [-0.5, -0.5]}],
        "box": [0.2, 0.2],
        "max_force": 500.0,
        "max_foot_speed": 8.0,
        "max_tilt": 1.0,
    }


@pytest.fixture
def quadruped(planar: dict[str, Any]) -> dict[str, Any]:
    """Four legs in space."""
    feet = {"LF": [0.4, 0.2, -0.5], "RF": [0.4, -0.2, -0.5], "LH": [-0.4, 0.2, -0.5], "RH": [-0.4, -0.2, -0.5]}
    return planar | {
        "name": "quadruped",
        "dimension": 3,
        "inertia": [[1.0, 0.0, 0.1], [0.0, 2.0, 0.0], [0.1, 0.0, 2.0]],
        "legs": [{"name": name, "default_foot": foot} for name, foot in feet.items()],
        "box": [0.16, 0.1, 0.04],
        "mirror": [["LF", "RF"], ["LH", "RH"]],
    }


def refusal(data: Any, folder: Path) -> str:
    """What load_robot says of this data, without the path it must begin with."""
    path = folder / "robot.yaml"
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        load_robot(path)
    assert str(caught.value).startswith(f"{path}: ")
    return str(caught.value).removeprefix(f"{path}: ")


@pytest.mark.parametrize("path", sorted(CONFIGS.glob("*.yaml")), ids=lambda path: path.stem)
def test_the_robots_of_the_project_load(path: Path) -> None:
    robot = load_robot(path)
    assert (robot.frames is None) == (robot.dimension == 2)
    assert robot.name == path.stem, "scenarios find a robot by its file's name"
    assert Robot.from_data(robot.as_data(), "copy") == robot


def test_shapes_of_a_quadruped(quadruped: dict[str, Any]) -> None:
    robot = Robot.from_data(quadruped, "here")
    assert robot.leg_names == ("LF", "RF", "LH", "RH")
    assert robot.mirror_permutation == (1, 0, 3, 2)
    assert np.array(robot.inertia).shape == (3, 3)
    assert robot.mass == 14.0
    assert isinstance(robot.mass, float)


def test_without_mirror_every_leg_is_its_own_image(planar: dict[str, Any]) -> None:
    assert Robot.from_data(planar, "here").mirror_permutation == (0, 1)


def test_a_leg_on_the_middle_line_stays_when_mirrored(quadruped: dict[str, Any]) -> None:
    quadruped["legs"].append({"name": "T", "default_foot": [0.0, 0.0, -0.5]})
    assert Robot.from_data(quadruped, "here").mirror_permutation == (1, 0, 3, 2, 4)


def test_a_robot_is_frozen(planar: dict[str, Any]) -> None:
    robot = Robot.from_data(planar, "here")
    with pytest.raises(ValidationError, match="frozen"):
        robot.mass = 1.0  # type: ignore[misc]
    with pytest.raises(ValidationError, match="frozen"):
        robot.legs[0].name = "X"  # type: ignore[misc]
    assert hash(robot) == hash(Robot.from_data(planar, "there"))


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [
        ("mass", -14.0, "mass = -14.0: Input should be greater than 0"),
        ("mass", 0, "mass = 0: Input should be greater than 0"),
        ("mass", float("nan"), "mass = nan: Input should be a finite number"),
        ("max_force", float("inf"), "max_force = inf: Input should be a finite number"),
        ("mass", "heavy", "mass = 'heavy': Input should be a valid number; this is text"),
        ("mass", None, "mass = None: Input should be a valid number"),
        ("dimension", 4, "dimension = 4: Input should be 2 or 3"),
        ("max_tilt", 2.0, "max_tilt = 2.0: Input should be less than 1.5"),
        ("name", "../half_cheetah", "name = '../half_cheetah': String should match pattern '^[a-z0-9_]+$'"),
        ("weight", 14.0, "weight = 14.0: unknown field; allowed: name, dimension, mass, inertia, legs, box, max_force"),
        ("box", [0.2], "box = (0.2,): must have 2 half lengths when dimension is 2"),
        ("box", [0.2, 0.2, 0.2], "box = (0.2, 0.2, 0.2): must have 2 half lengths when dimension is 2"),
        ("box", [0.2, -0.2], "box.1 = -0.2: Input should be greater than 0"),
        ("inertia", [[1, 0], [0, 1]], "inertia = ((1.0, 0.0), (0.0, 1.0)): must be 1 row(s) of 1 number(s) when"),
        ("inertia", [], "inertia = (): must be 1 row(s) of 1 number(s) when dimension is 2"),
        ("inertia", 1.2, "inertia = 1.2: Input should be a valid array"),
        ("inertia", [[-1.2]], "inertia = ((-1.2,),): must be symmetric and positive definite [kg m^2]"),
        ("legs", [], "legs = []: Tuple should have at least 1 item"),
        ("legs", [{"name": "f", "default_foot": [0, -1]}], "legs.0.name = 'f': String should match pattern"),
        ("legs", [{"name": "F"}], "legs.0.default_foot: missing"),
        ("legs", [{"name": "F", "default_foot": [0, 0, -1]}], "legs.F.default_foot = (0.0, 0.0, -1.0): must have 2"),
        ("legs", [{"name": "F", "default_foot": [0.5, -0.1]}], "legs.F.default_foot = (0.5, -0.1): with box = (0.2"),
        (
            "legs",
            [{"name": "F", "default_foot": [x, -1]} for x in (0, 1)],
            "legs: names = ['F', 'F']: each must differ",
        ),
        ("mirror", [["F", "X"]], "mirror = (('F', 'X'),): pairs of legs, none in two pairs or paired with itself; all"),
        ("mirror", [["F", "F"]], "mirror = (('F', 'F'),): pairs of legs"),
        ("mirror", [["F"]], "mirror.0.1: missing"),
    ],
)
def test_a_wrong_value_is_refused(planar: dict[str, Any], tmp_path: Path, field: str, value: Any, said: str) -> None:
    assert refusal(planar | {field: value}, tmp_path).startswith(said)


def test_what_is_allowed_is_listed(planar: dict[str, Any], tmp_path: Path) -> None:
    assert refusal(planar | {"mirror": [["F", "X"]]}, tmp_path).endswith("allowed: F, H")
    foot = [{"name": "F", "default_foot": [0.5, -0.1]}]
    assert refusal(planar | {"legs": foot}, tmp_path).endswith("its z must be below -0.2")


@pytest.mark.parametrize("field", ["mass", "legs", "max_foot_speed"])
def test_a_missing_field_is_named(planar: dict[str, Any], tmp_path: Path, field: str) -> None:
    del planar[field]
    assert refusal(planar, tmp_path) == f"{field}: missing; this field has no default"


@pytest.mark.parametrize(
    "inertia",
    [
        [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]],  # not symmetric
        [[1, 2, 0], [2, 1, 0], [0, 0, 1]],  # not positive definite
    ],
)
def test_an_inertia_that_no_body_has(quadruped: dict[str, Any], tmp_path: Path, inertia: list[list[float]]) -> None:
    assert "must be symmetric and positive definite" in refusal(quadruped | {"inertia": inertia}, tmp_path)


@pytest.mark.parametrize("largest", [5.0, 3.00001])
def test_principal_moments_obey_the_triangle_inequality(
    quadruped: dict[str, Any], tmp_path: Path, largest: float
) -> None:
    turn = Rotation.from_euler("y", 0.3).as_matrix()  # keeps the body left-right symmetric
    inertia = turn @ np.diag([1.0, 2.0, largest]) @ turn.T
    said = refusal(quadruped | {"inertia": ((inertia + inertia.T) / 2).round(9).tolist()}, tmp_path)
    assert said.startswith("inertia: its principal moments are 1 and 2 and ")
    assert "no body has one that is larger than the sum of the other two" in said


def test_a_flat_body_has_one_moment_that_is_the_sum_of_the_others(quadruped: dict[str, Any]) -> None:
    plate = [[0.1, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.1 + 0.2]]
    assert Robot.from_data(quadruped | {"inertia": plate}, "here").inertia[2][2] == 0.1 + 0.2


def test_a_leg_in_two_mirror_pairs(quadruped: dict[str, Any], tmp_path: Path) -> None:
    said = refusal(quadruped | {"mirror": [["LF", "RF"], ["LF", "RH"]]}, tmp_path)
    assert said.startswith("mirror = (('LF', 'RF'), ('LF', 'RH')): ")
    assert said.endswith("allowed: LF, RF, LH, RH")


def moved(quadruped: dict[str, Any], leg: int, foot: list[float]) -> dict[str, Any]:
    legs = [dict(entry) for entry in quadruped["legs"]]
    legs[leg]["default_foot"] = foot
    return quadruped | {"legs": legs}


@pytest.mark.parametrize("foot", [[0.4, -0.2001, -0.5], [0.41, -0.2, -0.5], [0.4, 0.2, -0.5], [0.4, -0.2, -0.51]])
def test_paired_feet_must_mirror_exactly(quadruped: dict[str, Any], tmp_path: Path, foot: list[float]) -> None:
    said = refusal(moved(quadruped, 1, foot), tmp_path)
    assert said.startswith("legs.LF.default_foot = (0.4, 0.2, -0.5): must be the mirror image of RF's, ")
    assert str((foot[0], -foot[1], foot[2])) in said


def test_a_foot_in_no_pair_must_be_in_the_middle(quadruped: dict[str, Any], tmp_path: Path) -> None:
    quadruped["legs"].append({"name": "T", "default_foot": [0.0, 0.01, -0.5]})
    said = refusal(quadruped, tmp_path)
    assert said.startswith("legs.T.default_foot = (0.0, 0.01, -0.5): must be in the middle plane")


@pytest.mark.parametrize(("row", "column", "said"), [(0, 1, "Ixy = 0.05"), (1, 2, "Iyz = 0.05")])
def test_a_lopsided_inertia_has_no_mirror(
    quadruped: dict[str, Any], tmp_path: Path, row: int, column: int, said: str
) -> None:
    inertia = [list(line) for line in quadruped["inertia"]]
    inertia[row][column] = inertia[column][row] = 0.05
    assert said in refusal(quadruped | {"inertia": inertia}, tmp_path)
    lopsided = renamed(quadruped, "ABCD") | {"inertia": inertia, "mirror": []}
    assert Robot.from_data(lopsided, "here").mirror == ()


def renamed(quadruped: dict[str, Any], names: Sequence[str]) -> dict[str, Any]:
    """The same feet under other names, no leg in a mirror pair."""
    legs = [leg | {"name": name} for leg, name in zip(quadruped["legs"], names, strict=True)]
    return quadruped | {"legs": legs, "mirror": []}


@pytest.mark.parametrize("names", [("LF", "RF", "LH", "RH"), ("FL", "FR", "RL", "RR")])
def test_legs_named_like_a_quadrupeds_need_its_mirror(
    quadruped: dict[str, Any], tmp_path: Path, names: tuple[str, ...]
) -> None:
    """Their gaits' names know neither left nor right: without `mirror`, two canonical gaits would share one."""
    said = refusal(renamed(quadruped, names), tmp_path)
    left_front, right_front, left_hind, right_hind = names
    assert said.startswith(
        f"mirror = (): must be [[{left_front}, {right_front}], [{left_hind}, {right_hind}]] for legs called "
    )
    assert "call the legs otherwise" in said
    assert Robot.from_data(renamed(quadruped, "ABCD"), "here").mirror == ()


def test_a_quadrupeds_mirror_swaps_left_and_right(quadruped: dict[str, Any], tmp_path: Path) -> None:
    feet = [[0.4, 0.2, -0.5], [-0.4, 0.2, -0.5], [0.4, -0.2, -0.5], [-0.4, -0.2, -0.5]]
    turned = quadruped | {
        "legs": [leg | {"default_foot": foot} for leg, foot in zip(quadruped["legs"], feet, strict=True)],
        "mirror": [["LF", "LH"], ["RF", "RH"]],
    }
    assert refusal(turned, tmp_path).startswith("mirror = (('LF', 'LH'), ('RF', 'RH')): must be [[LF, RF], [LH, RH]]")
    other_order = quadruped | {"mirror": [["RH", "LH"], ["LF", "RF"]]}
    assert Robot.from_data(other_order, "here").mirror_permutation == (1, 0, 3, 2)


def test_in_the_plane_paired_feet_are_in_one_place(planar: dict[str, Any], tmp_path: Path) -> None:
    feet = [{"name": name, "default_foot": [0.5, -0.5]} for name in ("L", "R")]
    assert Robot.from_data(planar | {"legs": feet, "mirror": [["L", "R"]]}, "here").mirror_permutation == (1, 0)
    said = refusal(planar | {"mirror": [["F", "H"]]}, tmp_path)
    assert said.startswith("legs.F.default_foot = (0.5, -0.5): must be the mirror image of H's, (-0.5, -0.5)")


@pytest.fixture
def framed(quadruped: dict[str, Any]) -> dict[str, Any]:
    """The quadruped with frames."""
    feet = [{"leg": leg["name"], "link": "foot", "contact_point": [0.0, 0.0, -0.01]} for leg in quadruped["legs"]]
    return quadruped | {"frames": {"base_link": "base", "com_in_base": [0.0, 0.001, -0.02], "feet": feet}}


def test_frames_are_beside_the_physics(framed: dict[str, Any], quadruped: dict[str, Any]) -> None:
    known, unknown = Robot.from_data(framed, "here"), Robot.from_data(quadruped, "here")
    assert known.frames is not None and known.frames.feet[1].leg == "RF"
    assert known.as_data()["frames"] == framed["frames"]
    assert "frames" not in unknown.as_data(), "robots without frames are the data that they were"
    assert Robot.from_data(known.as_data(), "copy") == known


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"feet": []}, "frames.feet: are of the legs (); allowed is one a leg, in their order: LF, RF, LH, RH"),
        ({"com_in_base": [0.0, 0.0]}, "frames.com_in_base.2: missing"),
        ({"base_link": ""}, "frames.base_link = '': "),
        ({"base": "base"}, "frames.base = 'base': unknown field, did you mean base_link? allowed: base_link, com_in"),
    ],
)
def test_frames_that_are_none(framed: dict[str, Any], tmp_path: Path, change: dict[str, Any], said: str) -> None:
    framed["frames"] |= change
    assert refusal(framed, tmp_path).startswith(said)


def test_frames_of_legs_in_another_order(framed: dict[str, Any], tmp_path: Path) -> None:
    framed["frames"]["feet"].reverse()
    assert "frames.feet: are of the legs ('RH', 'LH', 'RF', 'LF'); allowed is" in refusal(framed, tmp_path)


def test_a_robot_in_the_plane_has_no_frames(planar: dict[str, Any], framed: dict[str, Any], tmp_path: Path) -> None:
    said = refusal(planar | {"frames": framed["frames"] | {"feet": framed["frames"]["feet"][:2]}}, tmp_path)
    assert said == "frames: need a robot with dimension 3; leave them out"
