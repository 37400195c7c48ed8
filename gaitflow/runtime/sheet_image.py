"""Sheets of left-right mirror images: all of their numbers follow from those of the other pattern's sheet."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.task import AXES
from gaitflow.core.trajectory import Array
from gaitflow.solvers.point import GaitSpace

if TYPE_CHECKING:
    from gaitflow.runtime.atlas import Sheet


@dataclass(frozen=True, eq=False)
class SheetImage:
    """Which pattern's sheet a sheet is the image of, and how the numbers of its condensed points follow.

    places [c]: where each number of the other's points is in this one's; signs [c]: 1 or -1, what it is multiplied by.
    """

    of: str
    places: NDArray[np.intp]
    signs: NDArray[np.int8]

    def numbers(self, others: NDArray[np.float32]) -> NDArray[np.float32]:
        """This sheet's numbers [..., c] from the other's."""
        own = np.empty_like(others)
        own[..., self.places] = others * self.signs.astype(np.float32)
        return own


def imaged(other: Sheet, image: SheetImage, gait: int, pattern: str, space: GaitSpace, along: Array) -> Sheet:
    """The sheet of a pattern's image; `along` [a] are 1, or -1 for axes whose values change sign in a mirror."""
    return replace(
        other,
        gait=gait,
        pattern=pattern,
        space=space,
        tasks=other.tasks * along + 0.0,  # adding 0 turns -0 into 0
        slopes=other.slopes * along,
        mean=image.numbers(other.mean),
        modes=image.numbers(other.modes),
        tangents=other.tangents * along[:, None].astype(np.float32),
        infeasible=other.infeasible * along + 0.0,
        image=image,
    )


def signs_of(axes: tuple[str, ...]) -> Array:
    """-1 for each axis whose values change sign in a mirror, 1 for the others."""
    return np.array([-1.0 if AXES[axis].mirrored else 1.0 for axis in axes])
