"""The rotation that a unit quaternion stands for."""

from __future__ import annotations

import numpy as np

from gaitflow.core.trajectory import Array


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
