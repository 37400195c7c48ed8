"""Limbs read from URDFs: lengths that are known, one made by hand, and legs that are built otherwise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitflow.config.limbs import Limb
from gaitflow.config.robot import load_robot
from gaitflow.urdf.chain import LegChain
from gaitflow.urdf.importing import Imported, Request, import_robot
from gaitflow.urdf.limbs import limbs_of
from gaitflow.urdf.write import write_robot

Write = Callable[..., Path]
FOUND = {  # file, feet, thigh [m], shank [m], knees of LF and LH
    "anymal": ("anymal_b_simple_description/robots/anymal.urdf", "{}_FOOT", ("LF", "RF", "LH", "RH"), 0.25, 0.34, "bf"),
    "go1": ("go1_description/urdf/go1.urdf", "{}_foot", ("FL", "FR", "RL", "RR"), 0.213, 0.213, "bb"),
    "hyq": ("hyq_description/robots/hyq_no_sensors.urdf", "{}_foot", ("lf", "rf", "lh", "rh"), 0.35, 0.346, "bf"),
}  # fmt: skip


def limbs_in(imported: Imported) -> tuple[Limb, ...]:
    assert imported.robot.limbs is not None
    return imported.robot.limbs


@pytest.mark.parametrize("name", FOUND)
def test_lengths_that_are_known(name: str, example_robot: Callable[[str], Path]) -> None:
    path, foot, legs, thigh, shank, knees = FOUND[name]
    urdf = example_robot(f"example-robot-data/robots/{path}")
    imported = import_robot(Request(urdf, name, tuple(map(foot.format, legs))))
    limbs = limbs_in(imported)
    assert [limb.leg for limb in limbs] == ["LF", "RF", "LH", "RH"]
    for limb in limbs:
        assert (limb.thigh, limb.shank) == (pytest.approx(thigh, abs=1e-4), pytest.approx(shank, abs=5e-3))
    assert "".join(limb.knee[0] for limb in limbs[::2]) == knees
    assert limbs[1] == limbs[0].mirrored("RF") and limbs[3] == limbs[2].mirrored("RH")
    assert not any("energy" in said for said in imported.found)
    assert limbs[0].below == pytest.approx(0.08 if name == "hyq" else 0.0, abs=1e-6)


def test_limbs_by_hand(walker: list[LegChain], by_hand: Any) -> None:
    """Four legs of 0.5 kg at their feet, hips 0.3 m before and 0.1 m beside the centre of mass."""
    legs, centre = walker, np.array([0.0, 0.0, -0.04])
    feet = np.array([leg.foot_at(leg.stance)[0] - centre for leg in legs])
    found = limbs_of(legs, centre, feet, ((0, 1), (2, 3)))
    assert found is not None
    limb = found[0]
    depth = (by_hand.thigh + by_hand.shank) * np.cos(0.5)
    np.testing.assert_allclose(limb["hip"], by_hand.hip - centre, atol=1e-6)
    lengths = [limb[key] for key in ("aside", "below", "thigh", "shank")]
    assert lengths == pytest.approx([by_hand.offset, 0.0, by_hand.thigh, by_hand.shank], abs=1e-6)
    assert limb["abduction_inertia"] == pytest.approx(0.5 * (by_hand.offset**2 + depth**2) + 1e-4, abs=2e-6)
    from_knee = by_hand.shank * np.cos(0.5)  # straight above the foot's knee, as seen along the line to the hip
    expected = 0.5 * np.array([[depth**2, depth * from_knee], [depth * from_knee, by_hand.shank**2]]) + 1e-4
    np.testing.assert_allclose(limb["flexion_inertia"], expected, atol=2e-6)
    assert [each["mass"] for each in found] == pytest.approx([0.5] * 4)
    assert [each["leg"] for each in found] == ["LF", "RF", "LH", "RH"]
    assert [each["knee"] for each in found] == ["backward", "backward", "forward", "forward"]
    assert [each["aside"] > 0 for each in found] == [True, False, True, False]


@pytest.fixture
def request_(write: Write, by_hand: Any) -> Request:
    return Request(
        write(by_hand.text()), "walker", by_hand.feet, pose=by_hand.standing, max_force=200.0, box=(0.05, 0.05, 0.02)
    )


def test_legs_that_are_built_otherwise_have_none_and_it_is_said(write: Write, by_hand: Any, request_: Request) -> None:
    """With slanted abduction axes it is a robot all the same."""
    imported = import_robot(request_)
    assert limbs_in(imported)
    slanted = by_hand.text().replace('<axis xyz="1 0 0"/>', '<axis xyz="0.9 0 0.435889"/>')
    other = import_robot(replace(request_, urdf=write(slanted, "slanted.urdf")))
    assert other.robot.limbs is None
    said = "legs are not built of hip abduction, hip flexion and knee: no objective of energy"
    assert said in other.found and said in other.robot.source and said not in imported.found
    assert other.robot.legs == imported.robot.legs


@pytest.mark.parametrize("axis", ["0.435889 0.9 0", "0 0.9 0.435889"])
@pytest.mark.parametrize("joint", ["HFE", "KFE"])
def test_one_leg_that_is_built_otherwise_is_enough(write: Write, by_hand: Any, joint: str, axis: str) -> None:
    """Hip flexion that is not square to abduction, or a knee that is not along hip flexion."""
    text, feet = by_hand.text(), np.array([[0.3, 0.18, -0.44]] * 4)
    before, after = text.split(f'<joint name="RH_{joint}"')
    odd = f'<joint name="RH_{joint}"'.join([before, after.replace('"0 1 0"', f'"{axis}"', 1)])
    legs = by_hand.legs(write(odd))
    assert limbs_of(legs[:3], np.zeros(3), feet[:3], ()) is not None
    assert limbs_of(legs, np.zeros(3), feet, ()) is None


def test_a_leg_of_two_joints_is_none(walker: list[LegChain]) -> None:
    legs, feet = walker, np.array([[0.3, 0.18, -0.44]])
    assert limbs_of(legs[:1], np.zeros(3), feet, ()) is not None
    assert limbs_of([replace(legs[0], joints=legs[0].joints[1:])], np.zeros(3), feet, ()) is None


def test_round_trip(request_: Request, tmp_path: Path) -> None:
    robot = import_robot(request_).robot
    write_robot(tmp_path / "walker.yaml", robot, ["made by a test"], replace=False)
    again = load_robot(tmp_path / "walker.yaml")
    assert again == robot
    assert again.limbs == robot.limbs is not None
