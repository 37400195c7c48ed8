"""A quadruped that is easily worked out by hand, as URDF text, and the robots of example-robot-data."""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import files
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from gaitflow.urdf.chain import LegChain
from gaitflow.urdf.description import read_description
from gaitflow.urdf.mechanism import Mechanism, load_mechanism
from gaitflow.urdf.pose import find_srdf, pose_of

SIDES = {"LF": (1, 1), "RF": (1, -1), "LH": (-1, 1), "RH": (-1, -1)}
LIMIT = 'lower="-3.2" upper="3.2" effort="50" velocity="10"'


def inertial(mass: float, moments: tuple[float, float, float], at: str = "0 0 0") -> str:
    xx, yy, zz = moments
    return (
        f'<inertial><origin xyz="{at}"/><mass value="{mass}"/>'
        f'<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="0"/></inertial>'
    )


def joint(name: str, parent: str, child: str, axis: str, at: str, limit: str) -> str:
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}"/><axis xyz="{axis}"/><limit {limit}/></joint>'
    )


class ByHand:
    """A 20 kg body on four legs of three joints; each foot weighs 0.5 kg, the other links nothing to speak of."""

    hip = np.array([0.3, 0.1, 0.0])  # abduction joint of LF from the base link's origin, m
    offset = 0.08  # from the abduction axis outwards to the hip flexion joint, m
    thigh = shank = 0.25  # m
    feet = tuple(f"{leg}_foot" for leg in SIDES)
    knees: ClassVar = {"LF": -1.0, "RF": -1.0, "LH": 1.0, "RH": 1.0}  # rad
    standing = ",".join(f"{leg}_HAA=0,{leg}_HFE={-knee / 2},{leg}_KFE={knee}" for leg, knee in knees.items())

    def text(self, limit: str = LIMIT, more: str = "") -> str:
        """The URDF; in the pose `standing` each foot is straight below its hip flexion joint."""
        parts = [f'<robot name="walker"><link name="base">{inertial(20, (0.3, 0.8, 0.9))}</link>']
        for leg, (front, left) in SIDES.items():
            at = f"{front * self.hip[0]} {left * self.hip[1]} {self.hip[2]}"
            parts += [f'<link name="{leg}_{part}"/>' for part in ("hip", "thigh", "shank")]
            parts += [
                f'<link name="{leg}_foot">{inertial(0.5, (1e-4, 1e-4, 1e-4))}</link>',
                joint(f"{leg}_HAA", "base", f"{leg}_hip", "1 0 0", at, limit),
                joint(f"{leg}_HFE", f"{leg}_hip", f"{leg}_thigh", "0 1 0", f"0 {left * self.offset} 0", limit),
                joint(f"{leg}_KFE", f"{leg}_thigh", f"{leg}_shank", "0 1 0", f"0 0 {-self.thigh}", limit),
                f'<joint name="{leg}_ankle" type="fixed"><parent link="{leg}_shank"/><child link="{leg}_foot"/>'
                f'<origin xyz="0 0 {-self.shank}"/></joint>',
            ]
        return "\n".join([*parts, more, "</robot>"])

    def legs(self, urdf: Path) -> list[LegChain]:
        """The legs LF, RF, LH, RH of such a URDF, standing."""
        return legs_of(urdf, self.feet, self.standing)


@pytest.fixture(scope="session")
def by_hand() -> ByHand:
    """A quadruped that is easily worked out by hand."""
    return ByHand()


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    """Write a description and say where."""

    def to(text: str, name: str = "walker.urdf") -> Path:
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return path

    return to


def legs_of(urdf: Path, feet: tuple[str, ...], pose: str | None = None) -> list[LegChain]:
    description = read_description(urdf)
    mechanism = load_mechanism(description)
    own = mechanism.joints_of(feet)
    angles = pose_of(pose, mechanism, [joint for joints in own for joint in joints], find_srdf(description)).angles
    return [
        LegChain(mechanism, name, mechanism.link(foot), joints, angles)
        for name, foot, joints in zip(SIDES, feet, own, strict=True)
    ]


@pytest.fixture
def walker(write: Callable[..., Path], by_hand: ByHand) -> list[LegChain]:
    """The legs LF, RF, LH, RH of the quadruped made by hand, standing."""
    return by_hand.legs(write(by_hand.text()))


@pytest.fixture
def mechanism(walker: list[LegChain]) -> Mechanism:
    """The quadruped made by hand."""
    return walker[0].mechanism


@pytest.fixture(scope="session")
def example_robot() -> Callable[[str], Path]:
    """Where a file of the package example-robot-data is, by its path in a results' header."""

    def find(label: str) -> Path:
        found = [file for file in files("example-robot-data") or () if str(file).endswith(f"share/{label}")]
        assert len(found) == 1, f"{label} is not installed"
        return Path(str(found[0].locate()))

    return find


@pytest.fixture(scope="session")
def anymal(example_robot: Callable[[str], Path]) -> list[LegChain]:
    """The legs LF, RF, LH, RH of ANYmal B, standing."""
    urdf = example_robot("example-robot-data/robots/anymal_b_simple_description/robots/anymal.urdf")
    return legs_of(urdf, ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT"))
