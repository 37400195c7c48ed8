"""A random forest as numbers: the inner nodes of all its trees in one list, and the votes of its leaves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import onnx

from gaitflow.export.graph import Floats, Graph, Integers
from gaitflow.export.items import array, counts
from gaitflow.export.scaler import Scaler, read_scaler

_NODES = tuple(
    f"nodes_{name}" for name in ("treeids", "nodeids", "featureids", "modes", "values", "truenodeids", "falsenodeids")
)
_LEAVES = ("class_treeids", "class_nodeids", "class_ids", "class_weights")
_NOT_USED = ("nodes_hitrates", "nodes_missing_value_tracks_true")  # no value of a task is missing


@dataclass(frozen=True)
class Forest:
    """From each of `roots` [trees], a node leads to below[node] where x[axis] <= threshold, else to above[node].

    x is the scaled task. A place smaller than the number of nodes is a node, which lies behind the one that leads to
    it; others are leaves, whose number is what is beyond. The sum of the leaves' rows of `votes` [leaves, gaits] is the
    forest's; with two gaits there may be one column, v, and the votes are (1 - v, v).
    """

    scaler: Scaler
    roots: Integers
    axis: Integers
    threshold: Floats
    below: Integers
    above: Integers
    votes: Floats

    def items(self) -> Iterator[bytes]:
        """What map.bin says of it."""
        yield from self.scaler.items()
        yield counts(len(self.roots), len(self.axis), *self.votes.shape)
        yield array(self.roots, "<u4")
        yield array(self.axis, "<u4")
        yield array(self.threshold, "<f4")
        yield array(self.below, "<u4")
        yield array(self.above, "<u4")
        yield array(self.votes, "<f4")


_Key = tuple[int, int]  # a tree, and the number of a node in it


@dataclass(frozen=True)
class _Node:
    axis: int
    threshold: float
    below: _Key
    above: _Key
    leaf: bool


def read_forest(graph: Graph, node: onnx.NodeProto) -> Forest:
    """The trees of a TreeEnsembleClassifier. Raises CannotExport where they are none or do otherwise than Forest."""
    found = graph.attributes(node, *_NODES, *_LEAVES, *_NOT_USED, "classlabels_int64s", post_transform=(b"NONE",))
    if any(len({len(found[name]) for name in names}) != 1 for names in (_NODES, _LEAVES)):
        raise graph.refuse("the columns of its trees are not equally long")
    scaler, nodes = read_scaler(graph, node.input[0]), _nodes(graph, found)
    roots = list({key[0]: key for key in reversed(nodes)}.values())[::-1]  # the first node of each tree
    order = _in_order(graph, nodes, roots)
    inner, leaves = ([key for key in order if nodes[key].leaf == leaf] for leaf in (False, True))
    if any(not 0 <= nodes[key].axis < len(scaler.scale) for key in inner):
        raise graph.refuse("a tree asks for an axis that there is not")
    places = {key: place for place, key in enumerate([*inner, *leaves])}
    return Forest(
        scaler=scaler,
        roots=_integers(places[key] for key in roots),
        axis=_integers(nodes[key].axis for key in inner),
        threshold=np.array([nodes[key].threshold for key in inner], dtype=np.float32),
        below=_integers(places[nodes[key].below] for key in inner),
        above=_integers(places[nodes[key].above] for key in inner),
        votes=_votes(graph, found, leaves),
    )


def _integers(values: Iterable[int]) -> Integers:
    return np.array(list(values), dtype=np.int64)


def _nodes(graph: Graph, found: Mapping[str, Any]) -> dict[_Key, _Node]:
    """The nodes in the graph's order, in which those of a tree follow each other."""
    nodes: dict[_Key, _Node] = {}
    for tree, number, axis, mode, threshold, below, above in zip(*(found[name] for name in _NODES), strict=True):
        if mode not in (b"BRANCH_LEQ", b"LEAF") or (tree, number) in nodes:
            raise graph.refuse(
                f"node {number} of tree {tree} is of mode {mode.decode(errors='replace')!r}, or there twice"
            )
        nodes[tree, number] = _Node(axis, threshold, (tree, below), (tree, above), mode == b"LEAF")
    return nodes


def _in_order(graph: Graph, nodes: Mapping[_Key, _Node], roots: Sequence[_Key]) -> list[_Key]:
    """Each node behind the one that leads to it."""
    order: dict[_Key, None] = {}
    waiting = list(reversed(roots))
    while waiting:
        key = waiting.pop()
        if key not in nodes or key in order:
            raise graph.refuse(f"node {key[1]} of tree {key[0]} is missing or reached twice")
        order[key] = None
        if not nodes[key].leaf:
            waiting += [nodes[key].above, nodes[key].below]
    if len(order) != len(nodes):
        raise graph.refuse("a tree has nodes that nothing leads to")
    return list(order)


def _votes(graph: Graph, found: Mapping[str, Any], leaves: Sequence[_Key]) -> Floats:
    """Votes [leaves, classes], or [leaves, 1] where only the second's of two are given, named class 0."""
    classes = len(found["classlabels_int64s"])
    one = classes == 2 and len(set(found["class_ids"])) == 1
    rows = {key: row for row, key in enumerate(leaves)}
    votes = np.zeros((len(leaves), 1 if one else classes), dtype=np.float32)
    for tree, number, column, weight in zip(*(found[name] for name in _LEAVES), strict=True):
        if (tree, number) not in rows or not 0 <= column < votes.shape[1] or weight < 0:
            raise graph.refuse(f"node {number} of tree {tree} votes {weight:g} for class {column} of {classes}")
        votes[rows[tree, number], column] += np.float32(weight)
    return votes
