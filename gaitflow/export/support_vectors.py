"""Support vector machines, one a gait, as numbers: their vectors and coefficients."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import onnx

from gaitflow.export.graph import Floats, Graph
from gaitflow.export.items import array, counts
from gaitflow.export.scaler import Scaler, read_scaler


@dataclass(frozen=True)
class Machine:
    """The score sum(coefficients * exp(-gamma * |x - vectors|^2)) + bias of a scaled task x.

    coefficients [n], vectors [n, axes].
    """

    coefficients: Floats
    vectors: Floats
    gamma: float
    bias: float


@dataclass(frozen=True)
class SupportVectors:
    """A machine a gait; of two gaits one machine may give both scores, (-score, score)."""

    scaler: Scaler
    machines: tuple[Machine, ...]

    def items(self) -> Iterator[bytes]:
        """What map.bin says of it."""
        yield from self.scaler.items()
        yield counts(len(self.machines))
        for machine in self.machines:
            yield counts(len(machine.vectors))
            yield array([machine.gamma, machine.bias], "<f4")
            yield array(machine.coefficients, "<f4")
            yield array(machine.vectors, "<f4")


def read_support_vectors(graph: Graph, scores: onnx.NodeProto) -> SupportVectors:
    """The machines whose scores the node `scores` puts side by side.

    Raises CannotExport for other kernels, and for machines of more than two classes.
    """
    graph.attributes(scores, axis=(1, -1))
    columns = list(scores.input)
    if len(columns) == 2 and (both := _one_for_both(graph, *columns)):
        columns = [both]
    nodes = [_machine_node(graph, column) for column in columns]
    scalers = {node.input[0] for node in nodes}
    if len(scalers) != 1:
        raise graph.refuse("its machines take differently scaled tasks")
    scaler = read_scaler(graph, scalers.pop())
    return SupportVectors(scaler, tuple(_machine(graph, node, len(scaler.scale)) for node in nodes))


def _one_for_both(graph: Graph, first: str, second: str) -> str:
    """The one score of two gaits where the first column is the second times -1, else ""."""
    mul, other = graph.makers.get(first), graph.makers.get(second)
    if mul is None or mul.op_type != "Mul" or other is None or other.op_type != "Concat":
        return ""
    graph.attributes(other, axis=(1,))
    if list(mul.input)[1:] != [second] or not (graph.floats(mul, 0) == -1).all() or len(other.input) != 1:
        raise graph.refuse("the scores of two gaits are not opposite")
    return str(other.input[0])


def _machine_node(graph: Graph, column: str) -> onnx.NodeProto:
    """The SVMClassifier whose second column, times -1, is `column`."""
    part = graph.node(column, "Slice")
    bounds = [graph.integers(part, place).ravel().tolist() for place in (1, 2, 3)]
    if bounds != [[1], [2], [1]] or len(part.input) != 4:
        raise graph.refuse(f"the slice {bounds} of a machine's scores")
    opposite = graph.node(part.input[0], "Mul")
    if not (graph.floats(opposite, 1) == -1).all():
        raise graph.refuse("a machine's scores are not taken times -1")
    cast = graph.node(opposite.input[0], "Cast")
    graph.attributes(cast, to=(onnx.TensorProto.FLOAT,))
    node = graph.node(cast.input[0], "SVMClassifier")
    if list(node.output)[1:] != [cast.input[0]]:
        raise graph.refuse("a machine's label is taken for its score")
    return node


def _machine(graph: Graph, node: onnx.NodeProto, axes: int) -> Machine:
    found = graph.attributes(
        node,
        *("coefficients", "kernel_params", "rho", "support_vectors", "vectors_per_class"),
        classlabels_ints=([0, 1],),
        kernel_type=(b"RBF",),
        post_transform=(b"NONE",),
    )
    coefficients = np.array(found["coefficients"], dtype=np.float32)
    vectors = np.array(found["support_vectors"], dtype=np.float32)
    sizes = len(found["vectors_per_class"]), len(found["rho"]), len(found["kernel_params"])
    if (sizes, vectors.size) != ((2, 1, 3), coefficients.size * axes):
        raise graph.refuse(f"a machine of {coefficients.size} coefficients and {vectors.size} numbers in its vectors")
    if sum(found["vectors_per_class"]) != coefficients.size:
        raise graph.refuse("a machine has other vectors than its classes have")
    # The graph takes the machine's score times -1.
    return Machine(-coefficients, vectors.reshape(-1, axes), found["kernel_params"][0], -found["rho"][0])
