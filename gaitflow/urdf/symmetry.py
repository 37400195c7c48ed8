"""Left-right symmetry: which legs mirror each other, and the nearest body that is its own mirror image.

Gaits are merged under mirroring (paper, section III.C), so a robot with mirror pairs must be exactly symmetric. Real
ones are so but for a cable or a battery; how far off they were is reported.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gaitflow.config.file import ConfigError
from gaitflow.urdf.mechanism import Array

TOLERANCE = 0.05  # of a foot's distance from the centre of mass; of the geometric mean of two moments of inertia
MIRROR = np.array([1.0, -1.0, 1.0])


@dataclass(frozen=True)
class Symmetric:
    """A body made symmetric, and by how much it was not.

    feet [legs, 3] m and inertia [3, 3] kg m^2 in the base frame at the centre of mass; pairs of leg indices;
    foot_offset: farthest that a foot was moved [m]; products: Ixy and Iyz before they were set to 0 [kg m^2].
    """

    feet: Array
    inertia: Array
    pairs: tuple[tuple[int, int], ...]
    foot_offset: float
    products: tuple[float, float]


def mirror_pairs(feet: Array) -> tuple[tuple[int, int], ...]:
    """Pairs of legs, left first, whose feet [legs, 3] are nearest to each other's mirror image (y -> -y).

    A foot nearest to its own image is in no pair. Raises ConfigError when a foot's partner has another partner.
    """
    distance = np.linalg.norm(feet[:, None] * MIRROR - feet[None], axis=2)
    partner = distance.argmin(axis=1)
    if not np.array_equal(partner[partner], np.arange(len(feet))):
        raise ConfigError(
            f"feet at {np.round(feet, 3).tolist()} m have no left-right pairs: choose a symmetric pose with --pose"
        )
    pairs = [(i, int(j)) for i, j in enumerate(partner) if i < j]
    return tuple((i, j) if feet[i, 1] >= feet[j, 1] else (j, i) for i, j in pairs)


def symmetrised(feet: Array, inertia: Array, names: Sequence[str]) -> Symmetric:
    """Paired feet at their mean x, |y| and z, unpaired ones at y = 0, Ixy = Iyz = 0.

    feet [legs, 3] m, inertia [3, 3] kg m^2 about the centre of mass. Raises ConfigError beyond TOLERANCE.
    """
    pairs = mirror_pairs(feet)
    image = np.array(feet) * MIRROR
    for i, j in pairs:
        image[[i, j]] = image[[j, i]]
    even = (feet + image) / 2
    moved = np.linalg.norm(even - feet, axis=1)
    for name, distance, foot in zip(names, moved, feet, strict=True):
        if distance > TOLERANCE * np.linalg.norm(foot):
            raise ConfigError(
                f"leg {name}: its foot is {distance * 1e3:.1f} mm from the mirror image of its partner's, more than "
                f"{TOLERANCE:.0%} of its distance from the centre of mass: choose a symmetric pose with --pose"
            )
    for label, (i, j) in (("Ixy", (0, 1)), ("Iyz", (1, 2))):
        if abs(inertia[i, j]) > TOLERANCE * np.sqrt(abs(inertia[i, i] * inertia[j, j])):
            raise ConfigError(
                f"{label} = {inertia[i, j]:.4g} kg m^2 is more than {TOLERANCE:.0%} of the moments beside it: the body "
                "is not left-right symmetric, choose a symmetric pose with --pose or correct the URDF"
            )
    keep = np.outer(MIRROR, MIRROR) > 0
    return Symmetric(even, np.where(keep, inertia, 0.0), pairs, float(moved.max()), (inertia[0, 1], inertia[1, 2]))
