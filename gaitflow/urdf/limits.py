"""Force and speed of a foot from the URDF's effort and velocity limits, in the default pose."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import linprog

from gaitflow.config.file import ConfigError
from gaitflow.core.layout import GRAVITY
from gaitflow.urdf.chain import LegChain
from gaitflow.urdf.mechanism import Array

MOST_WEIGHTS = 10  # on one foot: an effort limit that allows more is a placeholder
MOST_JOINT_SPEED = 100.0  # rad/s, 16 turns a second: a velocity limit above it is a placeholder
LEAST_LEVER = 1e-6  # m: a joint whose axis the force passes this close by carries none of it


def max_vertical_force(legs: Sequence[LegChain]) -> float:
    """Largest vertical force [N] that every foot can hold in the pose: tau = J^T f within every joint's effort limit.

    Legs are massless, as in the paper's model: their own weight is not deducted. Raises ConfigError when the URDF
    states no usable effort limits.
    """
    force = min(_held(leg) for leg in legs)
    weight = legs[0].mechanism.mass * GRAVITY
    if force > MOST_WEIGHTS * weight:
        raise ConfigError(
            f"{legs[0].mechanism.label}: its effort limits allow {force:.4g} N on one foot, {force / weight:.4g} times "
            "the robot's weight: placeholders. Give what the motors can do with --max-force"
        )
    return force


def max_foot_speed(legs: Sequence[LegChain]) -> float:
    """Largest speed [m/s] that every foot can have along every axis of the base in the pose, one axis at a time.

    Raises ConfigError when the URDF states no usable velocity limits, or a foot cannot move along an axis.
    """
    return min(_speed(leg, axis) for leg in legs for axis in range(3))


def _held(leg: LegChain) -> float:
    lever = np.abs(leg.foot_at(leg.stance)[1][2])
    loaded = lever > LEAST_LEVER
    _require(leg, leg.effort[loaded], np.array(leg.joint_names)[loaded], "effort", "--max-force")
    if not loaded.any():
        raise ConfigError(f"leg {leg.name}: a vertical force on its foot loads no joint: give --max-force")
    return float(np.min(leg.effort[loaded] / lever[loaded]))


def _speed(leg: LegChain, axis: int) -> float:
    """max s with J qdot = s e_axis and |qdot| <= limits: a linear programme."""
    _require(leg, leg.velocity, np.array(leg.joint_names), "velocity", "--max-foot-speed")
    fast = leg.velocity > MOST_JOINT_SPEED
    if fast.any():
        raise ConfigError(
            f"leg {leg.name}: joint {leg.joint_names[int(fast.argmax())]} has a velocity limit of "
            f"{leg.velocity.max():g} rad/s: a placeholder. Give what the legs can do with --max-foot-speed"
        )
    jacobian = leg.foot_at(leg.stance)[1]
    cost = np.append(np.zeros(len(leg.joints)), -1.0)
    rows = np.hstack([jacobian, -np.eye(3)[:, [axis]]])
    limits = [*((-limit, limit) for limit in leg.velocity), (0.0, None)]
    speed = -linprog(cost, A_eq=rows, b_eq=np.zeros(3), bounds=limits).fun
    if speed < 1e-3:
        raise ConfigError(
            f"leg {leg.name}: its foot cannot move along {'xyz'[axis]} in this pose (a straight leg, or too few "
            "joints): choose another --pose, or give --max-foot-speed"
        )
    return float(speed)


def _require(leg: LegChain, limits: Array, names: Array, kind: str, option: str) -> None:
    missing = [str(name) for name, limit in zip(names, limits, strict=True) if not np.isfinite(limit)]
    if missing:
        raise ConfigError(f"leg {leg.name}: the URDF states no {kind} limit of {', '.join(missing)}: give {option}")
