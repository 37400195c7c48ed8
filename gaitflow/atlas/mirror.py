"""Left-right mirror images of nodes: half of the nodes of a map that is its own image are not solved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gaitflow.atlas.node import Node, Place
from gaitflow.core.gaits import Pattern
from gaitflow.core.trajectory import Array
from gaitflow.dataset.mirror import MirrorImage, Places
from gaitflow.runtime.sheet_image import SheetImage, signs_of
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

    def sheet(self, pattern: str, space: GaitSpace, of_image: GaitSpace) -> SheetImage:
        """How the condensed points of the image of a pattern follow from the pattern's; the spaces as for `node`."""
        (variables, of_variables), (rows, of_rows) = self.image.places
        count = len(space.lower)
        place, sign = np.concatenate([variables, count + rows]), np.concatenate([of_variables, of_rows])
        places, signs, before = list[NDArray[np.intp]](), list[Array](), 0
        for own, other in zip(_condensed_parts(space), _condensed_parts(of_image), strict=True):
            number = np.full(len(place), -1, dtype=np.intp)
            number[other] = before + np.arange(len(other))
            places.append(number[place[own]])
            signs.append(sign[own])
            before += len(other)
        return SheetImage(pattern, np.concatenate(places), np.concatenate(signs).astype(np.int8))

    @property
    def _signs(self) -> Array:
        """What the values on each axis are multiplied by."""
        return signs_of(tuple(self.axes))


def _condensed_parts(space: GaitSpace) -> tuple[NDArray[np.intp], ...]:
    """The variable, or row after all variables, that each number of a condensed point is of, for its three kinds."""
    count = len(space.lower)
    bounded = np.concatenate([space.free, count + space.unequal])[space.has_lower | space.has_upper]
    return space.free, count + space.equal, bounded


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
