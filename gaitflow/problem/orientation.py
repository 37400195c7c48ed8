"""Orientation of the base: one pitch angle in the plane; yaw, pitch, roll (Z-Y-X) in space.

In the plane, vectors are (x, z) and pitch is positive nose up, from x to z. In space, vectors are (x, y, z), angles are
Theta = (yaw, pitch, roll) with R_base->world = Rz(yaw) Ry(pitch) Rx(roll), and omega is in the base frame. The
full nonlinear rotation is used throughout.
"""

from __future__ import annotations

import casadi as ca


def world_to_base(angles: ca.SX) -> ca.SX:
    """R of eq. (5): rotates world vectors into the base frame; angles [a] rad -> [d, d]."""
    if angles.numel() == 1:
        c, s = ca.cos(angles), ca.sin(angles)
        return ca.vertcat(ca.horzcat(c, s), ca.horzcat(-s, c))
    yaw, pitch, roll = ca.vertsplit(angles)
    cy, sy, cp, sp = ca.cos(yaw), ca.sin(yaw), ca.cos(pitch), ca.sin(pitch)
    cr, sr = ca.cos(roll), ca.sin(roll)
    return ca.vertcat(
        ca.horzcat(cy * cp, sy * cp, -sp),
        ca.horzcat(cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr),
        ca.horzcat(cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr),
    )


def angle_rates(angles: ca.SX, omega: ca.SX) -> ca.SX:
    """Rates of the angles [a] rad/s for the angular velocity omega [a] rad/s (base frame)."""
    if angles.numel() == 1:
        return omega
    _, pitch, roll = ca.vertsplit(angles)
    p, q, r = ca.vertsplit(omega)
    yaw_rate = (ca.sin(roll) * q + ca.cos(roll) * r) / ca.cos(pitch)
    return ca.vertcat(yaw_rate, ca.cos(roll) * q - ca.sin(roll) * r, p + ca.sin(pitch) * yaw_rate)


def moment(lever: ca.SX, force: ca.SX) -> ca.SX:
    """Moment lever x force [a] N m of a force [d] N at a lever [d] m; in the plane, positive nose up."""
    if lever.numel() == 2:
        return lever[0] * force[1] - lever[1] * force[0]
    return ca.cross(lever, force)
