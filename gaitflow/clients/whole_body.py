"""A robot's whole body along a motion: joint angles by inverse kinematics, their velocities, torques, by pinocchio."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gaitflow.clients.rotation import rotation_of
from gaitflow.core.trajectory import Array
from gaitflow.motion import Frames, Motion, State
from gaitflow.urdf.description import read_description
from gaitflow.urdf.mechanism import BASE_VELOCITIES, Mechanism, load_mechanism
from gaitflow.urdf.pose import find_srdf, pose_of

CLOSE = 0.01  # m: what a foot may be off the map's robot, which was made left-right symmetric
ITERATIONS = 30
LEAST_DAMPING, DAMPING = 1e-8, 1e-5  # m^2, of angles and of velocities; a Jacobian's squares are some 0.05 m^2
MET = 1e-6  # m


@dataclass(frozen=True, eq=False)
class JointMotion:
    """A motion in pinocchio's coordinates at n times; the base's come first, joints in `Mechanism.joint_names`' order.

    times [n] s. configurations [n, nq]: base link's origin [m], quaternion (x, y, z, w), joints [rad]. velocities
    [n, nv]: base link's, linear [m/s] and angular [rad/s] in its own frame, joints [rad/s]. torques [n - 1, joints]
    N m: of the joints from one time to the next, by inverse dynamics with the planned forces. Velocities of joints
    and torques end at the joints' limits. missed [n, legs] m: how far the feet stay off the motion's, which is more
    than rounding only where a leg is too short.
    """

    times: Array
    configurations: Array
    velocities: Array
    torques: Array
    missed: Array


@dataclass(frozen=True, eq=False)
class WholeBody:
    """A URDF's moving tree, tied to the plans of a map. Build it with `load_whole_body`.

    feet [legs]: pinocchio's frames of the feet, in the order of the legs in a plan, whatever pinocchio's own is; joints
    [legs]: each leg's own ones. standing [joints] rad: the pose in which the map's robot was measured. Not to be shared
    between threads, as a Mechanism is not.
    """

    mechanism: Mechanism
    frames: Frames
    feet: tuple[int, ...]
    joints: tuple[tuple[int, ...], ...]
    standing: Array

    def configuration(self, position: Array, orientation: Array, angles: Array) -> Array:
        """Pinocchio's configuration [nq]: base link at [3] m with a quaternion (w, x, y, z), joints at [joints] rad."""
        q = self.mechanism.configuration(angles)
        q[:3], q[3:7] = position, np.roll(orientation, -1)
        return q

    def feet_at(self, configuration: Array) -> Array:
        """The feet [legs, 3] m of a configuration [nq], in the world."""
        import pinocchio

        model, data = self.mechanism.model, self.mechanism.data
        pinocchio.framesForwardKinematics(model, data, configuration)
        return np.array([data.oMf[foot].translation for foot in self.feet])

    def along(self, motion: Motion, times: Array) -> JointMotion:
        """The whole body at rising times [n] s of a motion, each pose found from the one before, first standing.

        Raises ValueError for a motion of another robot, on a slope or with a payload.
        """
        based = self._base_motion(motion)
        seen, within = based.sample(times), based.sample((times[:-1] + times[1:]) / 2)
        angles, found = self.standing.copy(), []
        for each in range(len(seen.time)):
            angles, *rest = self._at(seen, each, angles)
            found.append(rest)
        configurations, velocities, missed = (np.array(column) for column in zip(*found, strict=True))
        accelerations = np.diff(velocities, axis=0) / np.diff(times)[:, None]
        moving = zip(configurations, velocities, accelerations, within.forces, strict=False)
        torques = [self._torques(q, v, acceleration, forces) for q, v, acceleration, forces in moving]
        return JointMotion(seen.time, configurations, velocities, np.reshape(torques, (-1, len(angles))), missed)

    def _base_motion(self, motion: Motion) -> Motion:
        if Frames.of(motion.scenario) != self.frames:
            raise ValueError(
                f"{self.mechanism.label}: tied to another robot than that of the motion, {motion.scenario.get('name')}"
            )
        for axis in ("slope", "payload"):
            if motion.task[axis] != 0:
                raise ValueError(f"{axis} = {motion.task[axis]:g}: the whole body is on level ground, with no load")
        if motion.point == "base":
            return motion
        return Motion.of(
            motion.scenario, motion.trajectory, motion.task, motion.pattern, motion.swing_apex, point="base"
        )

    def _at(self, seen: State, which: int, near: Array) -> tuple[Array, Array, Array, Array]:
        """Angles, configuration, velocity and missed feet at one of the times."""
        turn = rotation_of(seen.orientation[which])
        position, omega = seen.position[which], seen.angular_velocity[which]
        speed = seen.velocity[which] @ turn  # in the base frame, as all that follows
        feet = (seen.feet[which] - position) @ turn
        paces = seen.foot_velocities[which] @ turn - speed - np.cross(omega, feet)
        angles, missed = self._reaching(feet, near)
        rates = np.zeros_like(angles)
        for leg, joints in enumerate(self.joints):
            _, jacobian = self.mechanism.point(self.feet[leg], angles)
            rates[list(joints)] = _damped(jacobian[:, joints], paces[leg], DAMPING)
        rates = np.clip(rates, -self.mechanism.velocity, self.mechanism.velocity)
        q = self.configuration(position, seen.orientation[which], angles)
        return angles, q, np.concatenate([speed, omega, rates]), missed

    def _torques(self, q: Array, v: Array, acceleration: Array, forces: Array) -> Array:
        """Torques [joints] N m that the joints' motion takes under forces [legs, 3] N on the feet."""
        import pinocchio

        model, data, world = self.mechanism.model, self.mechanism.data, pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
        torques = np.array(pinocchio.rnea(model, data, q, v, acceleration))
        for foot, force in zip(self.feet, forces, strict=True):
            jacobian = pinocchio.computeFrameJacobian(model, data, q, foot, world)
            torques -= jacobian[:3].T @ force
        return np.clip(torques[BASE_VELOCITIES:], -self.mechanism.effort, self.mechanism.effort)

    def _reaching(self, feet: Array, near: Array) -> tuple[Array, Array]:
        """Angles [joints] that put feet [legs, 3] m of the base frame nearest, from angles near by; distances [legs].

        Gauss-Newton steps, a leg at a time, within the joints' limits, damped as much as keeps the foot coming nearer:
        a leg that is too short ends up stretched.
        """
        mechanism, angles, missed = self.mechanism, near.copy(), np.zeros(len(feet))
        for leg, joints in enumerate(self.joints):
            own, damping = list(joints), LEAST_DAMPING
            at, jacobian = mechanism.point(self.feet[leg], angles)
            for _ in range(ITERATIONS):
                missed[leg] = np.linalg.norm(feet[leg] - at)
                if missed[leg] < MET:
                    break
                tried, step = angles.copy(), _damped(jacobian[:, own], feet[leg] - at, damping)
                tried[own] = np.clip(angles[own] + step, mechanism.lower[own], mechanism.upper[own])
                reached, turned = mechanism.point(self.feet[leg], tried)
                if np.linalg.norm(feet[leg] - reached) < missed[leg]:
                    angles, at, jacobian, damping = tried, reached, turned, max(damping / 10, LEAST_DAMPING)
                else:
                    damping *= 10
        return angles, missed


def load_whole_body(urdf: Path, scenario: Mapping[str, Any]) -> WholeBody:
    """The whole body of the robot of a scenario's JSON data (`plan.scenario`), from its robot description.

    Raises ConfigError for a description that cannot be read; ValueError for a scenario without frames and for a
    description of another robot.
    """
    frames = Frames.of(scenario)
    if frames is None:
        raise ValueError(
            f"the map {scenario.get('name')} does not know its robot's links: import the robot again by `gaitflow "
            "robot import` and publish the map anew"
        )
    description = read_description(urdf)
    mechanism = load_mechanism(description)
    links = [foot.link for foot in frames.feet]
    feet, joints = tuple(mechanism.link(link) for link in links), mechanism.joints_of(links)
    legs = [joint for own in joints for joint in own]
    pose = pose_of(None, mechanism, legs, find_srdf(description))
    body = WholeBody(mechanism, frames, feet, joints, pose.angles)
    _check_same_robot(body, scenario["robot"])
    return body


def _check_same_robot(body: WholeBody, robot: Mapping[str, Any]) -> None:
    """Raises ValueError where base link, mass, centre of mass or feet are not those of the map's robot."""
    mechanism, frames = body.mechanism, body.frames
    said = f"not the robot {robot['name']} of the map; take the description that it was imported from"
    if mechanism.base_link != frames.base_link:
        raise ValueError(
            f"{mechanism.label}: its base link is {mechanism.base_link!r}, not {frames.base_link!r}: {said}"
        )
    if not np.isclose(mechanism.mass, robot["mass"], rtol=1e-3):
        raise ValueError(f"{mechanism.label}: it weighs {mechanism.mass:.2f} kg, not {robot['mass']:.2f} kg: {said}")
    centre = np.array(frames.com_in_base)
    places = {"centre of mass": (mechanism.composite(body.standing)[0], centre)}
    for foot, frame, leg in zip(frames.feet, body.feet, robot["legs"], strict=True):
        places[f"link {foot.link}"] = mechanism.point(frame, body.standing)[0], centre + leg["default_foot"]
    for name, (found, known) in places.items():
        off = float(np.linalg.norm(found - known))
        if off > CLOSE:
            raise ValueError(f"{mechanism.label}: its {name} stands {off * 1e3:.0f} mm off the map's: {said}")


def _damped(jacobian: Array, wanted: Array, damping: float) -> Array:
    """The least-squares step, held back where the leg is stretched."""
    square = jacobian.T @ jacobian + damping * np.eye(jacobian.shape[1])
    return np.asarray(np.linalg.solve(square, jacobian.T @ wanted), dtype=np.float64)
