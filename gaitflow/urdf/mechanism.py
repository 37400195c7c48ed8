"""A URDF's moving tree through pinocchio: mass, centre of mass, inertia, feet and their Jacobians, base level."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitflow.config.file import ConfigError
from gaitflow.urdf.description import Description

Array = NDArray[np.float64]
BASE_VELOCITIES = 6  # the base's own coordinates come before the joints' in every velocity vector


@dataclass(frozen=True, eq=False)
class Mechanism:
    """Links and joints below a base that is held level at the origin: x forward, z up as the URDF draws it.

    Angles are [joints] vectors (rad, or m of a sliding joint) in the order of `joint_names`, and so are the limits
    `lower`, `upper`, `effort` (N m; inf where the URDF states none) and `velocity` (rad/s; inf likewise).
    `data` is pinocchio's scratch memory: a Mechanism must not be shared between threads.
    """

    label: str
    model: Any
    data: Any
    joint_names: tuple[str, ...]
    lower: Array
    upper: Array
    effort: Array
    velocity: Array

    @property
    def mass(self) -> float:
        """Mass of all links [kg]."""
        return float(sum(inertia.mass for inertia in self.model.inertias))

    def configuration(self, angles: Array) -> Array:
        """Pinocchio's configuration vector for these angles: base at the origin, level."""
        import pinocchio

        step = np.concatenate([np.zeros(BASE_VELOCITIES), angles])
        return np.asarray(pinocchio.integrate(self.model, pinocchio.neutral(self.model), step))

    def composite(self, angles: Array) -> tuple[Array, Array]:
        """Centre of mass [3] m and inertia of all links about it [3, 3] kg m^2, both in base axes."""
        import pinocchio

        pinocchio.ccrba(self.model, self.data, self.configuration(angles), np.zeros(self.model.nv))
        return np.array(self.data.com[0]), np.array(self.data.Ig.inertia)

    def base_inertia(self) -> Array:
        """Inertia of the base link with what is fixed to it, about its own centre of mass [3, 3] kg m^2."""
        return np.array(self.model.inertias[1].inertia)

    def link(self, name: str) -> int:
        """Pinocchio's frame of a link. Raises ConfigError that names close matches."""
        import pinocchio

        links = [frame.name for frame in self.model.frames if frame.type == pinocchio.FrameType.BODY]
        if name not in links:
            near = get_close_matches(name, links, 4, 0.3) or links[:12]
            raise ConfigError(f"{self.label}: no link {name!r}; it has {', '.join(near)}")
        return int(self.model.getFrameId(name, pinocchio.FrameType.BODY))

    @property
    def base_link(self) -> str:
        """The name of the link that all others hang on."""
        import pinocchio

        names = (frame.name for frame in self.model.frames if frame.type == pinocchio.FrameType.BODY)
        return str(next(names))

    def rotation(self, frame: int, angles: Array) -> Array:
        """Of a frame's vectors into the base frame's directions [3, 3]."""
        import pinocchio

        pinocchio.forwardKinematics(self.model, self.data, self.configuration(angles))
        pinocchio.updateFramePlacement(self.model, self.data, frame)
        return np.array(self.data.oMf[frame].rotation)

    def joint(self, index: int) -> int:
        """Pinocchio's frame of a joint."""
        import pinocchio

        return int(self.model.getFrameId(self.joint_names[index], pinocchio.FrameType.JOINT))

    def point(self, frame: int, angles: Array) -> tuple[Array, Array]:
        """Position [3] m of a frame's origin in the base frame and its Jacobian [3, joints]."""
        import pinocchio

        pinocchio.computeJointJacobians(self.model, self.data, self.configuration(angles))
        pinocchio.updateFramePlacement(self.model, self.data, frame)
        jacobian = pinocchio.getFrameJacobian(
            self.model, self.data, frame, pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        return np.array(self.data.oMf[frame].translation), np.array(jacobian[:3, BASE_VELOCITIES:])

    def axes(self, joints: Sequence[int], angles: Array) -> tuple[Array, Array]:
        """Origins [joints, 3] m and axes [joints, 3] of these joints, in the base frame."""
        import pinocchio

        jacobian = pinocchio.computeJointJacobians(self.model, self.data, self.configuration(angles))
        numbers = [self.model.getJointId(self.joint_names[joint]) for joint in joints]
        origins = np.array([self.data.oMi[number].translation for number in numbers])
        return origins, np.array([jacobian[3:, self.model.idx_vs[number]] for number in numbers])

    def carried(self, joints: Sequence[int]) -> float:
        """Mass [kg] of the links that these joints move directly."""
        numbers = (self.model.getJointId(self.joint_names[joint]) for joint in joints)
        return float(sum(self.model.inertias[number].mass for number in numbers))

    def joint_inertia(self, joints: Sequence[int], angles: Array) -> Array:
        """What these joints have to move, the base held: their part of the joint-space inertia [joints, joints]."""
        import pinocchio

        upper = np.triu(pinocchio.crba(self.model, self.data, self.configuration(angles)))
        whole = upper + np.triu(upper, 1).T
        own = [self.model.idx_vs[self.model.getJointId(self.joint_names[joint])] for joint in joints]
        return np.array(whole[np.ix_(own, own)])

    def joints_of(self, links: Sequence[str]) -> tuple[tuple[int, ...], ...]:
        """For each link the joints between it and the base that move no other of these links, base first.

        Raises ConfigError for a link that no joint moves.
        """
        chains = []
        for name in links:
            chain, at = [], self.model.frames[self.link(name)].parentJoint
            while at > 1:  # 0 is the world, 1 the base
                chain.append(self.joint_names.index(self.model.names[at]))
                at = self.model.parents[at]
            chains.append(chain[::-1])
        own = []
        for name, chain in zip(links, chains, strict=True):
            own.append(tuple(joint for joint in chain if sum(joint in other for other in chains) == 1))
            if not own[-1]:
                raise ConfigError(f"{self.label}: link {name!r} has no joint of its own towards the base: not a foot")
        return tuple(own)


def load_mechanism(description: Description) -> Mechanism:
    """The moving tree of a URDF; meshes are never opened. Raises ConfigError."""
    try:
        import pinocchio
    except ImportError as error:
        raise ConfigError(f'reading a URDF needs pinocchio ({error}): pip install "gaitflow[robots]"') from None
    try:
        model = pinocchio.buildModelFromXML(description.text, pinocchio.JointModelFreeFlyer())
    except (ValueError, RuntimeError, IndexError) as error:
        raise ConfigError(f"{description.path}: not a URDF that pinocchio reads ({error})") from None
    moving = list(model.joints)[2:]
    for name, joint in zip(list(model.names)[2:], moving, strict=True):
        if joint.nv != 1:
            raise ConfigError(f"{description.path}: joint {name!r} has {joint.nv} degrees of freedom, only 1 is known")
    turns = np.array([joint.nq == 2 for joint in moving], dtype=bool)  # without end: stored as cosine and sine
    ends = [joint.idx_q for joint in moving]
    if not moving:
        raise ConfigError(f"{description.path}: no joint moves")
    mass = sum(inertia.mass for inertia in model.inertias)
    if not np.isclose(mass, description.mass):  # urdfdom warns of an <inertial> that it cannot read, and leaves it out
        raise ConfigError(
            f"{description.path}: its links weigh {description.mass:g} kg, of which {mass:g} kg could be used: an "
            "<inertial> is not valid (each needs <mass> and an <inertia> with ixx, ixy, ixz, iyy, iyz, izz)"
        )
    return Mechanism(
        label=description.label,
        model=model,
        data=model.createData(),
        joint_names=tuple(model.names)[2:],
        lower=np.where(turns, -np.pi, np.array(model.lowerPositionLimit)[ends]),
        upper=np.where(turns, np.pi, np.array(model.upperPositionLimit)[ends]),
        effort=_stated(model.effortLimit),
        velocity=_stated(model.velocityLimit),
    )


def _stated(limits: Any) -> Array:
    """The joints' limits [joints], inf where a URDF says nothing or zero."""
    values = np.array(limits, dtype=float)[BASE_VELOCITIES:]
    return np.where(np.isfinite(values) & (values > 0), values, np.inf)
