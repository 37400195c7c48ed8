"""A classifier's ONNX graph, read from its output backwards: which node makes a value, and with which constants."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import numpy_helper

Floats = NDArray[np.float32]
Integers = NDArray[np.int64]


class CannotExport(ValueError):
    """A map, or a place to write to, that an export cannot use: names it and the way out."""


@dataclass(frozen=True)
class Graph:
    """`input` [n, axes] is the value that it all begins with; `where` and `kind` are for errors.

    Every question raises CannotExport where the graph holds something else than what it is asked for.
    """

    input: str
    tensors: Mapping[str, onnx.TensorProto]
    makers: Mapping[str, onnx.NodeProto]
    kind: str
    where: str

    def refuse(self, fault: str) -> CannotExport:
        """The error that says `fault`, for the caller to raise."""
        return CannotExport(
            f"{self.where}: a classifier of kind {self.kind!r} that the export does not know: {fault}; run "
            "classifier.onnx itself in your planner, with ONNX Runtime"
        )

    def node(self, value: str, *operators: str) -> onnx.NodeProto:
        """The node that makes a value, one of `operators`; what only passes the value on is skipped."""
        node = self.makers.get(value)
        while node is not None and node.op_type == "Identity":
            value, node = node.input[0], self.makers.get(node.input[0])
        if node is None or node.op_type not in operators:
            found = "no node" if node is None else node.op_type
            raise self.refuse(f"{value[:80]!r} comes from {found}, not from {' or '.join(operators)}")
        return node

    def expect_input(self, value: str) -> None:
        """The graph begins with this value."""
        if value != self.input:
            raise self.refuse(f"it begins with {value[:80]!r}, not with {self.input!r}")

    def attributes(self, node: onnx.NodeProto, *free: str, **allowed: tuple[Any, ...]) -> dict[str, Any]:
        """The attributes of a node by name: those in `free` with any value, others with one of those `allowed`."""
        found = {each.name: onnx.helper.get_attribute_value(each) for each in node.attribute}
        for name, value in found.items():
            if name not in free and value not in allowed.get(name, ()):
                raise self.refuse(f"{name} = {str(value)[:80]} of {node.op_type}")
            if isinstance(value, list) and value and isinstance(value[0], float) and not np.isfinite(value).all():
                raise self.refuse(f"{name} of {node.op_type} holds numbers that are not finite")
        for name in free:
            if name not in found:
                raise self.refuse(f"{node.op_type} without {name}")
        return found

    def floats(self, node: onnx.NodeProto, place: int) -> Floats:
        """The constant that is input number `place` of a node, float32."""
        return self._constant(node, place, onnx.TensorProto.FLOAT, "float32").astype(np.float32)

    def integers(self, node: onnx.NodeProto, place: int) -> Integers:
        """The constant that is input number `place` of a node, int64."""
        return self._constant(node, place, onnx.TensorProto.INT64, "int64").astype(np.int64)

    def _constant(self, node: onnx.NodeProto, place: int, kind: int, called: str) -> NDArray[Any]:
        name = node.input[place] if place < len(node.input) else ""
        if name not in self.tensors or self.tensors[name].data_type != kind:
            raise self.refuse(f"input {place} of {node.op_type} is no {called} constant: {name[:80]!r}")
        values = numpy_helper.to_array(self.tensors[name])
        if not np.isfinite(values).all():
            raise self.refuse(f"input {place} of {node.op_type} holds numbers that are not finite")
        return values


def read_graph(content: bytes, kind: str, where: str) -> Graph:
    """The graph in the bytes of a classifier.onnx that onnxruntime has loaded, which has one input and no cycle."""
    graph = onnx.load_model_from_string(content).graph
    return Graph(
        input=graph.input[0].name,
        tensors={tensor.name: tensor for tensor in graph.initializer},
        makers={value: node for node in graph.node for value in node.output},
        kind=kind,
        where=where,
    )
