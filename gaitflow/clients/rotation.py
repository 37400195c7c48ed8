"""Rotations: what a unit quaternion stands for, and about the vertical."""

from __future__ import annotations

import numpy as np

from gaitflow.core.trajectory import Array


def turned(vectors: Array, yaw: float) -> Array:
    """Vectors [n, 3] turned about the vertical by `yaw` [rad]."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.asarray(vectors @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]]))


def rotation_of(orientation: Array) -> Array:
    """The matrix [3, 3] that turns base vectors into the world, of a unit quaternion (w, x, y, z)."""
    w, x, y, z = orientation
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
