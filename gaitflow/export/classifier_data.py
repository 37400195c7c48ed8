"""The classifier of a map as numbers, for any of the methods: read off the ONNX graph, written to map.bin."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import onnx

from gaitflow.export.forest import Forest, read_forest
from gaitflow.export.graph import Floats, Graph, read_graph
from gaitflow.export.items import array, counts
from gaitflow.export.neighbours import Neighbours, read_neighbours
from gaitflow.export.perceptron import Perceptron, read_perceptron
from gaitflow.export.support_vectors import SupportVectors, read_support_vectors
from gaitflow.runtime.classifier import OUTPUT

Method = Perceptron | Forest | SupportVectors | Neighbours
KINDS = {Perceptron: 0, Forest: 1, SupportVectors: 2, Neighbours: 3}  # as map.bin numbers them


@dataclass(frozen=True)
class ClassifierData:
    """softmax(scores / temperature), where scores are the method's, or log(votes + smoothing) where it votes.

    All float32. smoothing [gaits], empty where the method has scores.
    """

    method: Method
    smoothing: Floats
    temperature: float

    def items(self) -> Iterator[bytes]:
        """What map.bin says of it."""
        yield counts(KINDS[type(self.method)])
        yield from self.method.items()
        yield counts(len(self.smoothing))
        yield array(self.smoothing, "<f4")
        yield array([self.temperature], "<f4")


def read_classifier(content: bytes, kind: str, where: str) -> ClassifierData:
    """The classifier in the bytes of a classifier.onnx that onnxruntime has loaded; `where` is what errors call it.

    Raises CannotExport for a graph that `gaitflow train` does not write, with the kind that the manifest names.
    """
    graph = read_graph(content, kind, where)
    softmax = graph.node(OUTPUT, "Softmax")
    graph.attributes(softmax, axis=(1, -1))
    temperature, end = 1.0, graph.node(softmax.input[0], "Div", "Gemm", "Log", "Concat")
    if end.op_type == "Div":
        temperature = _temperature(graph, end)
        end = graph.node(end.input[0], "Gemm", "Log", "Concat")
    if end.op_type == "Gemm":
        return ClassifierData(read_perceptron(graph, end), np.zeros(0, dtype=np.float32), temperature)
    if end.op_type == "Concat":
        return ClassifierData(read_support_vectors(graph, end), np.zeros(0, dtype=np.float32), temperature)
    smoothed = graph.node(end.input[0], "Add")
    return ClassifierData(_voting(graph, smoothed.input[0]), _smoothing(graph, smoothed), temperature)


def _voting(graph: Graph, value: str) -> Method:
    votes = graph.node(value, "TreeEnsembleClassifier", "ReduceMean")
    return read_forest(graph, votes) if votes.op_type == "TreeEnsembleClassifier" else read_neighbours(graph, votes)


def _smoothing(graph: Graph, node: onnx.NodeProto) -> Floats:
    smoothing = graph.floats(node, 1)
    if smoothing.ndim != 1 or not (smoothing > 0).all():
        raise graph.refuse(f"its votes are smoothed by {smoothing.tolist()}, not by a positive number a gait")
    return smoothing


def _temperature(graph: Graph, node: onnx.NodeProto) -> float:
    value = graph.floats(node, 1)
    if value.size != 1 or not value.ravel()[0] > 0:
        raise graph.refuse(f"scores are divided by {value.ravel()[:8].tolist()}, not by one positive number")
    return float(value.ravel()[0])
