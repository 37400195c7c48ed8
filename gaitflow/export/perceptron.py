"""A perceptron as numbers: its layers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import onnx

from gaitflow.export.graph import Floats, Graph
from gaitflow.export.items import array, counts


@dataclass(frozen=True)
class Layer:
    """weights [outputs, inputs] and biases [outputs]: weights @ x + biases."""

    weights: Floats
    biases: Floats


@dataclass(frozen=True)
class Perceptron:
    """The first layer takes the map's axes, the last gives a score a gait; between two, negative values become 0."""

    layers: tuple[Layer, ...]

    def items(self) -> Iterator[bytes]:
        """What map.bin says of it."""
        yield counts(len(self.layers))
        for layer in self.layers:
            yield counts(*layer.weights.shape)
            yield array(layer.weights.T, "<f4")  # so that the inner loop's sums are independent: four times as fast
            yield array(layer.biases, "<f4")


def read_perceptron(graph: Graph, last: onnx.NodeProto) -> Perceptron:
    """The layers that end in the node `last`. Raises CannotExport for anything between them but Relu."""
    layers, node = [_layer(graph, last)], last
    while node.input[0] != graph.input:
        relu = graph.node(node.input[0], "Relu")
        node = graph.node(relu.input[0], "Gemm")
        layers.append(_layer(graph, node))
    return Perceptron(tuple(reversed(layers)))


def _layer(graph: Graph, node: onnx.NodeProto) -> Layer:
    attributes = graph.attributes(node, transB=(0, 1), transA=(0,), alpha=(1.0,), beta=(1.0,))
    weights, biases = graph.floats(node, 1), graph.floats(node, 2)
    weights = weights if attributes.get("transB", 0) else weights.T
    if weights.ndim != 2 or biases.shape != weights.shape[:1]:
        raise graph.refuse(f"weights {weights.shape} and biases {biases.shape} do not fit together")
    return Layer(np.ascontiguousarray(weights), biases)
