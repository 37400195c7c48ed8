"""Nearest neighbours as numbers: the known tasks and their gaits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import onnx

from gaitflow.export.graph import Floats, Graph, Integers
from gaitflow.export.items import array, counts


@dataclass(frozen=True)
class Neighbours:
    """The gaits' shares among the `nearest` of the tasks `known` [n, axes] to x / scale; of equal ones the first.

    scale [axes], gait [n] the number of each known task's; there are `gaits` of them.
    """

    scale: Floats
    known: Floats
    gait: Integers
    gaits: int
    nearest: int

    def items(self) -> Iterator[bytes]:
        """What map.bin says of it."""
        yield array(self.scale, "<f4")
        yield counts(self.nearest, len(self.known), self.gaits)
        yield array(self.known, "<f4")
        yield array(self.gait, "<u4")


def read_neighbours(graph: Graph, votes: onnx.NodeProto) -> Neighbours:
    """The tasks from which the node `votes` takes the mean ballot. Raises CannotExport where they vote otherwise."""
    graph.attributes(votes, axes=([1],), keepdims=(0,))
    gather = graph.node(votes.input[0], "Gather")
    graph.attributes(gather, axis=(0,))
    ballots = graph.floats(gather, 0)
    top = graph.node(gather.input[1], "TopK")
    graph.attributes(top, largest=(0,), sorted=(1,), axis=(-1, 1))
    if list(top.output)[1:] != [gather.input[1]]:
        raise graph.refuse("ballots are taken by distance, not by place")
    total = graph.node(top.input[0], "ReduceSum")
    graph.attributes(total, keepdims=(0,))
    square = graph.node(total.input[0], "Mul")
    difference = graph.node(square.input[0], "Sub")
    query = graph.node(difference.input[0], "Unsqueeze")
    scaled = graph.node(query.input[0], "Div")
    graph.expect_input(scaled.input[0])
    scale, known = graph.floats(scaled, 1), graph.floats(difference, 1)
    nearest = graph.integers(top, 1).ravel()
    if len(set(square.input)) != 1 or [graph.integers(total, 1).tolist(), graph.integers(query, 1).tolist()] != [
        [-1],
        [1],
    ]:
        raise graph.refuse("its distances are not Euclidean")
    if known.ndim != 3 or known.shape[::2] != (1, scale.size) or ballots.shape[:1] != known.shape[1:2]:
        raise graph.refuse(f"tasks {known.shape} and ballots {ballots.shape} do not fit together")
    if nearest.size != 1 or not 1 <= nearest[0] <= known.shape[1] or not (scale > 0).all():
        raise graph.refuse(f"the nearest {nearest.tolist()} of {known.shape[1]} tasks over {scale.tolist()}")
    if ballots.ndim != 2 or not np.array_equal(np.sort(ballots, axis=1), _one_a_row(*ballots.shape)):
        raise graph.refuse("a known task has not one vote for one gait")
    return Neighbours(scale, known[0], ballots.argmax(axis=1), ballots.shape[1], int(nearest[0]))


def _one_a_row(rows: int, columns: int) -> Floats:
    return np.repeat(np.eye(columns, dtype=np.float32)[-1:], rows, axis=0)
