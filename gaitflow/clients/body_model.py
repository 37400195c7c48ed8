"""A single rigid body under forces on its feet, for CasADi: what predictive control steps through."""

from __future__ import annotations

from typing import Any

import numpy as np

from gaitflow.core.trajectory import Array
from gaitflow.motion import State

BODY_STATE = 12


def import_casadi() -> Any:
    """CasADi. Raises ImportError that says how to get it."""
    try:
        import casadi
    except ImportError as error:
        raise ImportError(f'predictive control needs CasADi ({error}): pip install "gaitflow[clients]"') from None
    return casadi


def body_states(seen: State) -> Array:
    """States [n, 12] of a motion: centre of mass [m], velocity [m/s], yaw, pitch, roll [rad], base rates [rad/s].

    The rotation is that about z by yaw, then y by pitch, then x by roll; rates are in the base frame. Angles do not
    jump from one time to the next.
    """
    w, x, y, z = seen.orientation.T
    yaw = np.unwrap(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    return np.column_stack([seen.position, seen.velocity, yaw, pitch, roll, seen.angular_velocity])


def step_function(inertia: Array, legs: int) -> Any:
    """The next state after h seconds of constant forces, by a Runge-Kutta step of fourth order, as a CasADi function.

    Its arguments: state [12], forces [3 legs] N, feet [3 legs] m, gravity [3] m/s^2, mass [kg], h [s]. inertia [3, 3]
    kg m^2 is about the centre of mass, in the base frame.
    """
    ca = import_casadi()
    state, forces, feet = ca.SX.sym("x", BODY_STATE), ca.SX.sym("f", 3 * legs), ca.SX.sym("feet", 3 * legs)
    gravity, mass, h = ca.SX.sym("g", 3), ca.SX.sym("m"), ca.SX.sym("h")

    def rate(x: Any) -> Any:
        position, velocity, angles, omega = x[:3], x[3:6], x[6:9], x[9:]
        force, torque = ca.SX.zeros(3), ca.SX.zeros(3)
        for leg in range(0, 3 * legs, 3):
            force += forces[leg : leg + 3]
            torque += ca.cross(feet[leg : leg + 3] - position, forces[leg : leg + 3])
        yaw, pitch, roll = angles[0], angles[1], angles[2]
        turn = _turn(ca, 2, yaw) @ _turn(ca, 1, pitch) @ _turn(ca, 0, roll)
        across = ca.sin(roll) * omega[1] + ca.cos(roll) * omega[2]
        yawing = across / ca.cos(pitch)
        pitching = ca.cos(roll) * omega[1] - ca.sin(roll) * omega[2]
        rolling = omega[0] + ca.sin(pitch) * yawing
        spin = np.linalg.inv(inertia) @ (turn.T @ torque - ca.cross(omega, inertia @ omega))
        return ca.vertcat(velocity, force / mass + gravity, yawing, pitching, rolling, spin)

    k1 = rate(state)
    k2 = rate(state + h / 2 * k1)
    k3 = rate(state + h / 2 * k2)
    k4 = rate(state + h * k3)
    after = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return ca.Function("step", [state, forces, feet, gravity, mass, h], [after])


def _turn(ca: Any, axis: int, angle: Any) -> Any:
    """The rotation [3, 3] about a coordinate axis."""
    c, s = ca.cos(angle), ca.sin(angle)
    a, b = (axis + 1) % 3, (axis + 2) % 3
    turn = ca.SX.eye(3)
    turn[a, a], turn[a, b], turn[b, a], turn[b, b] = c, -s, s, c
    return turn
