"""The classifier of a map as numbers: the layers of its perceptron, read off the ONNX graph."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import numpy_helper

Floats = NDArray[np.float32]

_PERCEPTRON = re.compile(r"(Gemm Relu )*Gemm( Div)? Softmax")


class CannotExport(ValueError):
    """A map, or a place to write to, that an export cannot use: names it and the way out."""


@dataclass(frozen=True)
class Layer:
    """weights [outputs, inputs] and biases [outputs]: weights @ x + biases."""

    weights: Floats
    biases: Floats


@dataclass(frozen=True)
class Network:
    """softmax(scores / temperature) of the last layer's scores; between two layers negative values become 0.

    All float32. The first layer takes the map's ranged axes, the last gives a score a gait.
    """

    layers: tuple[Layer, ...]
    temperature: float


def read_network(content: bytes, kind: str, where: str) -> Network:
    """The perceptron in the bytes of a classifier.onnx that onnxruntime has loaded; `where` is what errors call it.

    Raises CannotExport for any other graph, with the kind of classifier that the manifest names.
    """
    graph = onnx.load_model_from_string(content).graph
    nodes = list(graph.node)
    names = " ".join(node.op_type for node in nodes)
    chained = all(after.input[:1] == before.output[:1] for before, after in pairwise(nodes))
    if not _PERCEPTRON.fullmatch(names) or not chained or nodes[0].input[0] != graph.input[0].name:
        raise CannotExport(
            f"{where}: the classifier is of kind {kind!r}, a graph of {names[:200]}; only a perceptron (mlp) becomes "
            "data. Export a version of the map whose manifest names the kind mlp, or run classifier.onnx itself in "
            "your planner, with ONNX Runtime"
        )
    reader = _Graph({tensor.name: tensor for tensor in graph.initializer}, where)
    layers = tuple(reader.layer(node) for node in nodes if node.op_type == "Gemm")
    temperatures = [reader.temperature(node) for node in nodes if node.op_type == "Div"]
    reader.expect(nodes[-1], axis=(1, -1))
    return Network(layers, temperatures[0] if temperatures else 1.0)


@dataclass(frozen=True)
class _Graph:
    tensors: Mapping[str, onnx.TensorProto]
    where: str

    def layer(self, node: onnx.NodeProto) -> Layer:
        attributes = self.expect(node, transB=(0, 1), transA=(0,), alpha=(1.0,), beta=(1.0,))
        weights, biases = (self.constant(node, place) for place in (1, 2))
        weights = weights if attributes.get("transB", 0) else weights.T
        if weights.ndim != 2 or biases.shape != weights.shape[:1]:
            raise CannotExport(f"{self.where}: weights {weights.shape} and biases {biases.shape} do not fit together")
        return Layer(np.ascontiguousarray(weights), biases)

    def temperature(self, node: onnx.NodeProto) -> float:
        value = self.constant(node, 1)
        if value.size != 1:
            raise CannotExport(f"{self.where}: scores are divided by {value.size} numbers; expected one")
        return float(value.ravel()[0])

    def constant(self, node: onnx.NodeProto, place: int) -> Floats:
        name = node.input[place] if place < len(node.input) else ""
        if name not in self.tensors or self.tensors[name].data_type != onnx.TensorProto.FLOAT:
            raise CannotExport(f"{self.where}: input {place} of {node.op_type} is no float32 constant: {name[:80]!r}")
        return numpy_helper.to_array(self.tensors[name])

    def expect(self, node: onnx.NodeProto, **allowed: tuple[float, ...]) -> dict[str, Any]:
        """The attributes of a node, refused when one is not among those `allowed`."""
        found = {each.name: onnx.helper.get_attribute_value(each) for each in node.attribute}
        for name, value in found.items():
            if value not in allowed.get(name, ()):
                raise CannotExport(f"{self.where}: {name} = {value!r} of {node.op_type} is not known to the export")
        return found
