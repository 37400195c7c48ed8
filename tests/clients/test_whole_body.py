"""The whole body against pinocchio's own kinematics and dynamics, on ANYmal."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio
import pytest

from gaitflow.clients.default_gaits import default_motion
from gaitflow.clients.whole_body import WholeBody, load_whole_body
from gaitflow.motion import Motion, standing
from gaitflow.runtime import Plan

TIMES = np.arange(0.0, 1.2, 0.02)


@pytest.mark.parametrize("which", ["planned", "trot"])
def test_feet_and_base_are_where_the_motion_has_them(
    body: WholeBody, which: str, request: pytest.FixtureRequest
) -> None:
    motion: Motion = request.getfixturevalue(which)
    found, seen = body.along(motion, TIMES), motion.of_mass().sample(TIMES)
    assert found.missed.max() < 1e-5
    model, data = body.mechanism.model, body.mechanism.data
    for q, v, feet, velocities in zip(
        found.configurations, found.velocities, seen.feet, seen.foot_velocities, strict=True
    ):
        pinocchio.forwardKinematics(model, data, q, v)
        for leg, foot in enumerate(motion.leg_names):
            frame = model.getFrameId(f"{foot}_FOOT")
            pinocchio.updateFramePlacement(model, data, frame)
            np.testing.assert_allclose(data.oMf[frame].translation, feet[leg], atol=1e-5)
            speed = pinocchio.getFrameVelocity(model, data, frame, pinocchio.LOCAL_WORLD_ALIGNED).linear
            np.testing.assert_allclose(speed, velocities[leg], atol=5e-3)


def test_velocities_are_those_of_the_configurations(body: WholeBody, trot: Motion) -> None:
    times = 0.1 + np.arange(20) * 1e-4
    found = body.along(trot, times)
    for q, after, v, then in zip(
        found.configurations, found.configurations[1:], found.velocities, found.velocities[1:], strict=False
    ):
        moved = pinocchio.difference(body.mechanism.model, q, after) / 1e-4
        np.testing.assert_allclose(moved, (v + then) / 2, atol=2e-2)


def test_torques_of_standing_hold_the_robot_still(body: WholeBody, planned: Motion) -> None:
    found, forces = body.along(standing(planned), np.array([0.0, 0.1])), standing(planned).at(0.05).forces
    np.testing.assert_allclose(found.configurations[:, 7:], np.tile(body.standing, (2, 1)), atol=5e-3)
    model, data, q = body.mechanism.model, body.mechanism.data, found.configurations[0]
    given = np.concatenate([np.zeros(6), found.torques[0]])
    for foot, force in zip(body.feet, forces, strict=True):
        jacobian = pinocchio.computeFrameJacobian(model, data, q, foot, pinocchio.LOCAL_WORLD_ALIGNED)
        given += jacobian[:3].T @ force
    acceleration = pinocchio.aba(model, data, q, np.zeros(model.nv), given)
    # The map's robot is exactly symmetric, the description is so within a millimetre.
    np.testing.assert_allclose(acceleration, 0, atol=0.5)


def test_a_foot_that_no_leg_reaches_is_missed_and_said_so(body: WholeBody, plan: Plan) -> None:
    missed = body.along(plan.motion(swing_apex=1.5), np.arange(0.0, 0.6, 0.01)).missed
    assert 0.3 < missed.max() < 1.0


def test_another_robot_is_refused_in_one_line(anymal: Path, plan: Plan) -> None:
    def changed(**robot: Any) -> dict[str, Any]:
        return {**plan.scenario, "robot": plan.scenario["robot"] | robot}

    robot = plan.scenario["robot"]
    frames, legs = robot["frames"], [dict(leg) for leg in robot["legs"]]
    legs[1]["default_foot"] = [0.37, -0.26, -0.46]
    swapped = frames | {"feet": [frames["feet"][i] for i in (1, 0, 2, 3)]}
    cases = {
        "links": {key: each for key, each in robot.items() if key != "frames"},
        "base link is 'base'": changed(frames=frames | {"base_link": "torso"})["robot"],
        "kg": changed(mass=12.0)["robot"],
        "link RF_FOOT stands 6": changed(legs=legs)["robot"],
        "link RF_FOOT stands 39": changed(frames=swapped)["robot"],
    }
    for said, other in cases.items():
        with pytest.raises(ValueError, match=said) as error:
            load_whole_body(anymal, {**plan.scenario, "robot": other})
        assert "\n" not in str(error.value)


def test_motions_that_the_body_cannot_follow_are_refused(body: WholeBody, trot: Motion) -> None:
    uphill = default_motion(trot.scenario, "trot", trot.task.replaced(slope=5.0), 0.5)
    with pytest.raises(ValueError, match="slope = 5"):
        body.along(uphill, TIMES)
    robot = trot.scenario["robot"]
    frames = robot["frames"] | {"com_in_base": [0.0, 0.0, 0.1]}
    other = default_motion({**trot.scenario, "robot": robot | {"frames": frames}}, "trot", trot.task, 0.5)
    with pytest.raises(ValueError, match="another robot"):
        body.along(other, TIMES)
