"""A robot as a MuJoCo model: its URDF without meshes, balls for feet, a floor, the task's gravity and payload."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np
from numpy.typing import NDArray

from gaitflow.clients.description import RobotDescription
from gaitflow.config.file import ConfigError
from gaitflow.core.rigid_body import RigidBody
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array

BASE = 6  # the base's velocities come before the joints'
PHYSICS_STEP = 1e-3  # s
STIFFNESS = (0.005, 1.0)  # time constant [s] and damping ratio of contacts
PAYLOAD_RADIUS = 0.05  # m, of the ball that a payload is
FLOOR = "floor"


@dataclass(frozen=True, eq=False)
class Leg:
    """A leg's place in the model: its foot's body and geom, and where its three joints are among all velocities.

    centre [3] m is the foot's ball in the body's frame, standing [3] m the same from the plan's foot in base axes.
    """

    name: str
    body: int
    geom: int
    velocities: NDArray[np.intp]
    centre: Array
    radius: float
    standing: Array


@dataclass(frozen=True, eq=False)
class RobotModel:
    """A robot on the ground of a task. The world is the plan's: x along the ground, z normal to it.

    physics is MuJoCo's model, which must not be changed: velocities are those of the base link (linear in the world,
    angular in the base), then one a joint, each with a motor that has the URDF's effort limit [joints] N m, inf where
    it states none, and friction of friction_torque [joints] N m. standing [joints] rad is the pose that the robot was
    imported in. ground [m] is the floor's z: as far below the plan's as it is below the origins of the feet's links;
    height [m] that of the standing base above it.

    friction, mass [kg], gravity [3] m/s^2, inertia [3, 3] kg m^2 about the centre of mass and `centre`, its place in
    the base [3] m, are the plan's.
    """

    physics: Any
    legs: tuple[Leg, ...]
    standing: Array
    effort: Array
    friction_torque: Array
    ground: float
    height: float
    friction: float
    mass: float
    gravity: Array
    inertia: Array
    centre: Array

    @classmethod
    def of(cls, description: RobotDescription, scenario: Mapping[str, Any], task: Task) -> RobotModel:
        """The robot of a scenario's JSON data. Raises ConfigError for one whose legs have not three joints each."""
        body = RigidBody.of(scenario["robot"], task)
        spec = _spec(description)
        base = spec.body(description.frames.base_link)
        base.add_freejoint()
        if task["payload"] > 0:
            _carry(base, task["payload"], description.frames.com_in_base)
        ground = -description.depth
        spec.worldbody.add_geom(
            name=FLOOR, type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], pos=[0, 0, ground], contype=1, conaffinity=2
        )
        for foot in description.feet:
            spec.body(foot.link).add_geom(
                name=foot.leg,
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=[foot.radius, 0, 0],
                pos=foot.centre,
                mass=0,
                contype=2,
                conaffinity=1,
            )
        for geom in spec.geoms:
            geom.friction = [task["friction"], 0.0, 0.0]
            geom.condim = 3
            geom.solref[:2] = STIFFNESS
        spec.option.gravity = body.gravity
        spec.option.timestep = PHYSICS_STEP
        spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        spec.option.impratio = 10.0
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        physics = spec.compile()
        legs = tuple(_leg(physics, description, number) for number in range(len(description.feet)))
        joints = physics.nv - BASE
        if sorted(np.concatenate([leg.velocities for leg in legs])) != list(range(BASE, physics.nv)):
            raise ConfigError(
                f"{description.urdf.label}: has joints besides its legs', and the controller moves legs only: give a "
                "URDF in which they are fixed"
            )
        limits = physics.jnt_actfrcrange[1:]
        names = [physics.joint(1 + joint).name for joint in range(joints)]
        return cls(
            physics=physics,
            legs=legs,
            standing=np.array([description.pose[name] for name in names]),
            effort=np.where(limits[:, 1] > limits[:, 0], limits[:, 1], np.inf),
            friction_torque=np.array(physics.dof_frictionloss[BASE:]),
            ground=ground,
            height=-float(body.default_feet[:, 2].mean()) - description.frames.com_in_base[2] - ground,
            friction=task["friction"],
            mass=body.mass,
            gravity=body.gravity,
            inertia=body.inertia,
            centre=np.array(description.frames.com_in_base),
        )


def _spec(description: RobotDescription) -> Any:
    """The links and joints of a URDF, without meshes and collision bodies."""
    root = ElementTree.fromstring(description.urdf.text)
    for link in root.findall("link"):
        for part in (*link.findall("visual"), *link.findall("collision")):
            link.remove(part)
    for part in [child for child in root if child.tag not in ("link", "joint")]:
        root.remove(part)
    options = ElementTree.SubElement(root, "mujoco")
    # Placeholders for the inertia of a sensor or an empty link are no reason to refuse a robot.
    ElementTree.SubElement(
        options, "compiler", fusestatic="false", balanceinertia="true", boundmass="1e-6", boundinertia="1e-9"
    )
    try:
        return mujoco.MjSpec.from_string(ElementTree.tostring(root, encoding="unicode"))
    except ValueError as error:
        raise ConfigError(f"{description.urdf.path}: not a URDF that MuJoCo reads ({error})") from None


def _carry(base: Any, payload: float, centre: tuple[float, float, float]) -> None:
    moment = 0.4 * payload * PAYLOAD_RADIUS**2
    base.add_body(name="payload", pos=centre, mass=payload, inertia=[moment] * 3, explicitinertial=True)


def _leg(physics: Any, description: RobotDescription, number: int) -> Leg:
    foot = description.feet[number]
    body = at = physics.body(foot.link).id
    velocities: list[int] = []
    while physics.body_parentid[at]:  # up to the base, which hangs on the world
        first, count = physics.body_jntadr[at], physics.body_jntnum[at]
        velocities = [*(int(physics.jnt_dofadr[first + i]) for i in range(count)), *velocities]
        at = physics.body_parentid[at]
    if len(velocities) != 3:
        raise ConfigError(
            f"{description.urdf.label}: leg {foot.leg} has {len(velocities)} joints; the controller is for legs of 3"
        )
    return Leg(foot.leg, body, physics.geom(foot.leg).id, np.array(velocities), foot.centre, foot.radius, foot.standing)
