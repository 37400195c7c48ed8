"""Torques and rates of a leg in closed form against pinocchio's Jacobian and inertia of the robots' URDFs."""

from __future__ import annotations

import shlex
from importlib.metadata import files
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from terms import numbers

from gaitflow.config.limbs import Limb
from gaitflow.config.robot import load_robot
from gaitflow.core.trajectory import Array
from gaitflow.problem.limb import LegPose
from gaitflow.urdf.chain import LegChain
from gaitflow.urdf.description import read_description
from gaitflow.urdf.mechanism import load_mechanism
from gaitflow.urdf.pose import find_srdf, pose_of

CONFIGS = Path(__file__).parents[2] / "configs" / "robots"
ROBOTS = ("anymal", "go1", "hyq")  # HyQ's flexion axis is below its abduction axis
LIMBS = [limb for name in ROBOTS for limb in load_robot(CONFIGS / f"{name}.yaml").limbs or ()]
Leg = tuple[Limb, LegChain, Array]


def leg_of(robot: str, index: int) -> Leg:
    """A limb, the URDF's leg that it was made of, and the centre of mass [3] m in the base link's frame."""
    path = CONFIGS / f"{robot}.yaml"
    words = shlex.split(path.read_text(encoding="utf-8").splitlines()[0])
    options = dict(zip(words[7::2], words[8::2], strict=True))
    (found,) = (file for file in files("example-robot-data") or () if str(file).endswith(f"share/{words[6]}"))
    description = read_description(Path(str(found.locate())))
    mechanism, feet = load_mechanism(description), options["--feet"].split(",")
    own = mechanism.joints_of(feet)
    pose = pose_of(options.get("--pose"), mechanism, [j for joints in own for j in joints], find_srdf(description))
    limbs = load_robot(path).limbs
    assert limbs is not None
    chain = LegChain(mechanism, limbs[index].leg, mechanism.link(feet[index]), own[index], pose.angles)
    return limbs[index], chain, mechanism.composite(pose.angles)[0] * [1.0, 0.0, 1.0]  # made symmetric


def signs(chain: LegChain) -> Array:
    """Of a URDF's joints against ours [3]: abduction about x, flexion from x to z, which is about -y."""
    _, axes = chain.mechanism.axes(chain.joints, chain.pose)
    return np.array([np.sign(axes[0, 0]), -np.sign(axes[1, 1]), -np.sign(axes[2, 1])])


def values(pose: LegPose, what: str, vector: Any) -> Array:
    return numbers(getattr(pose, what)(ca.SX(ca.DM(list(vector)))))


def at(limb: Limb, foot: Any) -> LegPose:
    return LegPose(limb, ca.SX(ca.DM(list(foot))))


@pytest.mark.parametrize("index", range(4))
@pytest.mark.parametrize("robot", ROBOTS)
def test_torques_and_rates_are_those_of_the_urdfs_jacobian(robot: str, index: int) -> None:
    """To the digits of a robot's file, and as far as its left legs are the mirror images of its right ones."""
    limb, chain, centre = leg_of(robot, index)
    rng, sign = np.random.default_rng(index), signs(chain)
    for _ in range(10):
        foot, jacobian = chain.foot_at(chain.stance + rng.uniform(-0.4, 0.4, 3))
        force, velocity = rng.uniform(-100, 100, 3), rng.uniform(-1, 1, 3)
        pose = at(limb, foot - centre)
        torques, rates = sign * (jacobian.T @ force), sign * np.linalg.solve(jacobian, velocity)
        np.testing.assert_allclose(values(pose, "torques", force), torques, atol=3e-4 * np.abs(torques).max())
        np.testing.assert_allclose(values(pose, "rates", velocity), rates, atol=3e-4 * np.abs(rates).max())


@pytest.mark.parametrize("index", range(4))
@pytest.mark.parametrize("robot", ROBOTS)
def test_a_swinging_legs_torques_are_those_of_the_urdfs_inertia(robot: str, index: int) -> None:
    """Standing, the base held; but for what couples abduction with the other two joints, which is left out.

    Go1's left legs are 0.2 % from the mirror images of its right ones; a file has the mean.
    """
    limb, chain, centre = leg_of(robot, index)
    sign = signs(chain)
    foot, jacobian = chain.foot_at(chain.stance)
    inertia = chain.mechanism.joint_inertia(chain.joints, chain.pose)
    inertia[0, 1:] = inertia[1:, 0] = 0.0
    for acceleration in np.eye(3):
        expected = sign * (inertia @ np.linalg.solve(jacobian, acceleration))
        found = values(at(limb, foot - centre), "inertial_torques", acceleration)
        np.testing.assert_allclose(found, expected, atol=3e-3 * np.abs(expected).max())


numbers_of_one = st.floats(-1.0, 1.0)
vectors = st.tuples(numbers_of_one, numbers_of_one, numbers_of_one).map(np.array)


def somewhere(limb: Limb, share: Array) -> Array:
    """A foot [3] m within the limb's reach, below its hip."""
    reach = limb.thigh + limb.shank
    below = limb.below + reach * (0.65 + 0.15 * share[2])
    return np.array(limb.hip) + np.array([0.2 * reach * share[0], limb.aside + 0.2 * reach * share[1], -below])


@given(st.sampled_from(LIMBS), vectors, vectors, vectors)
def test_no_power_is_lost_between_joints_and_foot(limb: Limb, share: Array, force: Array, velocity: Array) -> None:
    pose = at(limb, somewhere(limb, share))
    power = values(pose, "torques", force) @ values(pose, "rates", velocity)
    assert power == pytest.approx(force @ velocity, abs=1e-9)


@given(st.sampled_from(LIMBS), vectors, vectors)
def test_a_mirrored_leg_has_mirrored_torques(limb: Limb, share: Array, force: Array) -> None:
    flip, turned = np.array([1.0, -1.0, 1.0]), np.array([-1.0, 1.0, 1.0])
    foot = somewhere(limb, share)
    image = at(limb.mirrored("M"), foot * flip)
    for what in ("torques", "rates", "inertial_torques"):
        there = values(image, what, force * flip)
        np.testing.assert_allclose(there, turned * values(at(limb, foot), what, force), atol=1e-9)


@pytest.mark.parametrize("far", [(2.0, 0.0, -0.5), (0.0, 0.0, -3.0), (0.0, 0.1, 0.05)])
@pytest.mark.parametrize("limb", LIMBS[::4], ids=ROBOTS)
def test_out_of_reach_numbers_stay_finite(limb: Limb, far: tuple[float, float, float]) -> None:
    """A solver looks there on its way: values and derivatives must lead it back."""
    foot, force = ca.SX.sym("foot", 3), ca.SX(ca.DM([10.0, 20.0, 30.0]))
    pose = LegPose(limb, foot)
    told = ca.vertcat(pose.torques(force), pose.rates(force))
    seen = ca.Function("seen", [foot], [told, ca.jacobian(told, foot)])
    place = np.array(limb.hip) + np.array([0.0, limb.aside, 0.0]) + far
    assert all(np.isfinite(value.full()).all() for value in seen(place))
