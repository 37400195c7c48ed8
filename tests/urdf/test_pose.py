"""Poses from an SRDF and from the command line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitflow.config.file import ConfigError
from gaitflow.urdf.description import read_description
from gaitflow.urdf.mechanism import Mechanism, load_mechanism
from gaitflow.urdf.pose import find_srdf, pose_of

Write = Callable[..., Path]
Srdf = Callable[..., str]
LEGS = range(12)


@pytest.fixture
def srdf_text(by_hand: Any) -> Srdf:
    """Text of an SRDF with one pose, the standing one unless changed."""

    def text(name: str = "walker", state: str = "standing", **changed: str) -> str:
        values = dict(part.split("=") for part in by_hand.standing.split(",")) | changed
        joints = "".join(f'<joint name="{joint}" value="{value}"/>' for joint, value in values.items())
        root = '<joint name="root_joint" value="0 0 1 0 0 0 1"/>'
        return f'<robot name="{name}"><group_state name="{state}" group="all">{root}{joints}</group_state></robot>'

    return text


def test_a_pose_written_out(mechanism: Mechanism, by_hand: Any) -> None:
    pose = pose_of(by_hand.standing, mechanism, LEGS, None)
    for leg, knee in by_hand.knees.items():
        assert pose.angles[mechanism.joint_names.index(f"{leg}_KFE")] == knee


@pytest.mark.parametrize(("state", "asked"), [("standing", None), ("half_sitting", None), ("crouched", "crouched")])
def test_a_pose_of_the_srdf(
    mechanism: Mechanism, write: Write, state: str, asked: str | None, srdf_text: Srdf, by_hand: Any
) -> None:
    srdf = read_description(write(srdf_text(state=state), "a.srdf"))
    pose = pose_of(asked, mechanism, LEGS, srdf)
    np.testing.assert_array_equal(pose.angles, pose_of(by_hand.standing, mechanism, LEGS, None).angles)
    assert pose.label == f"pose {state}"


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (None, "which pose? (no SRDF of this robot was found): name one with --pose and --srdf, or give every leg"),
        ("standing", "no pose 'standing' (no SRDF"),
        ("LF_HAA=0", "no value for the leg joints LF_HFE, LF_KFE, LH_HAA"),
        ("tail=1", "no joint tail; joints are LF_HAA"),
        ("LF_HAA=x", "'LF_HAA=x' is not JOINT=RAD"),
        ("LF_HAA=nan", "'LF_HAA=nan' is not JOINT=RAD"),
        ("LF_HAA=0,LF_HAA=1", "is given twice"),
        ("=1", "'=1' is not JOINT=RAD"),
    ],
)
def test_a_pose_that_cannot_be_used(mechanism: Mechanism, asked: str | None, said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        pose_of(asked, mechanism, LEGS, None)
    assert said in str(caught.value)


def test_a_value_beyond_its_limits(mechanism: Mechanism, by_hand: Any) -> None:
    asked = by_hand.standing.replace("LF_HFE=0.5", "LF_HFE=3.5")
    with pytest.raises(ConfigError, match=r"LF_HFE = 3\.5 is beyond the joint's limits, -3\.2 to 3\.2"):
        pose_of(asked, mechanism, LEGS, None)


def test_poses_that_there_are_get_listed(mechanism: Mechanism, write: Write, srdf_text: Srdf) -> None:
    srdf = read_description(write(srdf_text(state="crouched"), "a.srdf"))
    for asked in (None, "standing"):
        with pytest.raises(ConfigError, match=r"a\.srdf has crouched"):
            pose_of(asked, mechanism, LEGS, srdf)


def test_a_value_in_the_srdf_that_is_none(mechanism: Mechanism, write: Write, srdf_text: Srdf) -> None:
    srdf = read_description(write(srdf_text(LF_HAA="straight"), "a.srdf"))
    with pytest.raises(ConfigError, match="joint 'LF_HAA' has value 'straight', not a number"):
        pose_of(None, mechanism, LEGS, srdf)


def test_joints_that_are_no_legs_stay_where_they_can(write: Write, by_hand: Any) -> None:
    arm = (
        '<link name="arm"/><joint name="elbow" type="revolute"><parent link="base"/><child link="arm"/>'
        '<axis xyz="0 1 0"/><limit lower="0.4" upper="1" effort="1" velocity="1"/></joint>'
    )
    mechanism = load_mechanism(read_description(write(by_hand.text(more=arm))))
    legs = [joint for joint, name in enumerate(mechanism.joint_names) if name != "elbow"]
    angles = pose_of(by_hand.standing, mechanism, legs, None).angles
    assert angles[mechanism.joint_names.index("elbow")] == 0.4


@pytest.mark.parametrize("name", ["walker.srdf", "../srdf/other.srdf"])
def test_the_srdf_beside(write: Write, name: str, srdf_text: Srdf, by_hand: Any) -> None:
    urdf = read_description(write(by_hand.text(), "urdf/walker.urdf"))
    assert find_srdf(urdf) is None
    write(srdf_text(name="stranger"), "urdf/stranger.srdf")
    assert find_srdf(urdf) is None
    write(srdf_text(), f"urdf/{name}")
    found = find_srdf(urdf)
    assert found is not None and found.path.name == Path(name).name


def test_of_several_srdfs_the_one_called_alike_or_none(write: Write, srdf_text: Srdf, by_hand: Any) -> None:
    urdf = read_description(write(by_hand.text(), "urdf/walker.urdf"))
    write(srdf_text(), "srdf/a.srdf")
    write(srdf_text(), "srdf/b.srdf")
    with pytest.raises(ConfigError, match=r"a\.srdf, b\.srdf all fit: choose with --srdf"):
        find_srdf(urdf)
    write(srdf_text(), "srdf/walker.srdf")
    found = find_srdf(urdf)
    assert found is not None and found.path.name == "walker.srdf"
