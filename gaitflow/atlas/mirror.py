"""Left-right mirror images of nodes: half of the nodes of a map that is its own image are not solved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gaitflow.atlas.node import Node, Place
from gaitflow.core.gaits import Pattern
from gaitflow.core.task import AXES
from gaitflow.core.trajectory import Array
from gaitflow.dataset.mirror import MirrorImage, Places
from gaitflow.solvers.point import GaitSpace


@dataclass
class NodeImages:
    """Takes nodes over some axes to their images, for one scenario."""

    image: MirrorImage
    axes: Sequence[str]
    _places: dict[tuple[Pattern, Pattern], Places] = field(default_factory=dict)

    def pattern(self, pattern: Pattern) -> Pattern:
        """The image of a pattern."""
        return pattern.mirrored(self.image.scenario.robot.mirror_permutation)

    def place(self, place: Place) -> Place:
        """The image of a place."""
        return tuple((self._signs * place + 0.0).tolist())  # adding 0 turns -0 into 0

    def node(self, node: Node, pattern: Pattern, space: GaitSpace, of_image: GaitSpace) -> Node:
        """The image of a pattern's node; the spaces are the pattern's and that of its image."""
        signs = self._signs
        pair = pattern, self.pattern(pattern)
        if pair not in self._places:
            self._places[pair] = _encoded(space, of_image, *self.image.places)
        place, sign = self._places[pair]
        point, tangents = np.empty_like(node.point), np.empty_like(node.tangents)
        point[place] = sign * node.point
        tangents[:, place] = signs[:, None] * sign * node.tangents
        return Node(self.place(node.place), node.cost, signs * node.slopes, point, tangents)

    @property
    def _signs(self) -> Array:
        """What the values on each axis are multiplied by."""
        return np.array([-1.0 if AXES[axis].mirrored else 1.0 for axis in self.axes])


def _encoded(space: GaitSpace, of_image: GaitSpace, variables: Places, rows: Places) -> Places:
    """Where the image of each number of an encoded point is, and with which sign."""
    count = len(space.lower)
    place = np.concatenate([variables[0], count + rows[0]])
    sign = np.concatenate([variables[1], rows[1]])

    def number(members: Sequence[NDArray[np.intp]], size: int) -> NDArray[np.intp]:
        """For each variable or row its place in a list of them, -1 without one."""
        numbers = np.full(size, -1, dtype=np.intp)
        listed = np.concatenate(members)
        numbers[listed] = np.arange(len(listed))
        return numbers

    def parts(of: GaitSpace) -> tuple[list[NDArray[np.intp]], ...]:
        bounded = np.concatenate([of.free, count + of.unequal])
        return (
            [of.free],
            [count + of.equal, count + of.unequal],
            [bounded[of.has_lower]],
            [bounded[of.has_upper]],
        )

    size, starts, there = len(place), list[int](), list[NDArray[np.intp]]()
    for members in parts(of_image):
        starts.append(sum(int((each >= 0).sum()) for each in there))
        there.append(number(members, size))
    free, every, lower, upper = (np.concatenate(members) for members in parts(space))
    # What is below a variable is above its image where the sign changes.
    lowers = np.where(sign[lower] > 0, starts[2] + there[2][place[lower]], starts[3] + there[3][place[lower]])
    uppers = np.where(sign[upper] > 0, starts[3] + there[3][place[upper]], starts[2] + there[2][place[upper]])
    places = np.concatenate([there[0][place[free]], starts[1] + there[1][place[every]], lowers, uppers])
    return places, np.concatenate([sign[free], sign[every], np.ones(len(lower) + len(upper))])
