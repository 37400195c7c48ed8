"""Damaged classifiers: ONNX graphs that loop, grow, lie about shapes and types, or say no probabilities."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import onnx
from onnx import AttributeProto, TensorProto, helper, numpy_helper

LARGE = 2**40
INTEGERS = (-1, 0, 1, 7, 10**9, 2**31, LARGE, -(2**63), 2**63 - 1)
FLOATS = (1e38, -1e38, float("nan"), float("inf"), -1.0, 0.0)
OPERATORS = (
    "Loop", "If", "Scan", "Sqrt", "Relu", "Softmax", "Log", "Einsum", "Gemm", "TopK", "Gather", "Concat", "Tile",
    "ConstantOfShape", "Expand", "SVMClassifier", "TreeEnsembleClassifier", "Scaler", "Cast", "",
)  # fmt: skip
WEIGHTS = "weights.bin"


def damaged(content: bytes, outside: Path, chance: random.Random) -> tuple[str, bytes]:
    """How a graph was damaged, and what came of it; `outside` is a folder that nothing may read from."""
    model = onnx.load_model_from_string(content)
    how = chance.choice(list(WAYS))
    WAYS[how](model, outside, chance)
    return how, model.SerializeToString()


def _operator(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    chance.choice(model.graph.node).op_type = chance.choice(OPERATORS)


def _domain(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    chance.choice(model.graph.node).domain = chance.choice(["", "ai.onnx.ml", "com.microsoft", "x"])
    chance.choice(model.opset_import).version = chance.choice([0, 1, 5, 11, 99, 2**31])


def _attribute(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    """One number or text of an attribute."""
    attribute = chance.choice([each for node in model.graph.node for each in node.attribute])
    attribute.i, attribute.f = chance.choice(INTEGERS), chance.choice(FLOATS)
    for numbers, odd in ((attribute.ints, INTEGERS), (attribute.floats, FLOATS)):
        if numbers:
            numbers[chance.randrange(len(numbers))] = chance.choice(odd)
    if attribute.s:
        attribute.s = chance.choice([b"", b"POLY", b"LINEAR", b"SIGMOID", b"SOFTMAX", b"PROBIT", b"x"])
    if attribute.strings:
        modes = [b"LEAF", b"BRANCH_LEQ", b"BRANCH_EQ", b"BRANCH_GT", b"x"]
        attribute.strings[chance.randrange(len(attribute.strings))] = chance.choice(modes)


def _attribute_length(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    listed = [each for node in model.graph.node for each in node.attribute if each.ints or each.floats or each.strings]
    attribute = chance.choice(listed or [each for node in model.graph.node for each in node.attribute])
    how = chance.choice(["empty", "shorter", "half", "longer", "double"])
    for values in (attribute.ints, attribute.floats, attribute.strings):
        kept = list(values)
        changed = {
            "empty": [], "shorter": kept[:-1], "half": kept[: len(kept) // 2], "longer": kept + kept[-1:],
            "double": kept + kept,
        }[how]  # fmt: skip
        del values[:]
        values.extend(changed)


def _attribute_type(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    attribute = chance.choice([each for node in model.graph.node for each in node.attribute])
    attribute.type = chance.choice([AttributeProto.INT, AttributeProto.FLOATS, AttributeProto.STRING, 0, 99])


def _no_attribute(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    node = chance.choice([node for node in model.graph.node if node.attribute])
    del node.attribute[chance.randrange(len(node.attribute))]


def _constant(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    """Numbers that need not give probabilities."""
    chosen = chance.choice(model.graph.initializer)
    value = np.array(numpy_helper.to_array(chosen))
    if value.dtype.kind == "f":
        with np.errstate(all="ignore"):
            odd = [value * np.float32(1e30), value * np.float32("nan"), value.ravel()[:1], -value, value * 0]
            value = chance.choice(odd)
    elif value.dtype.kind == "i":
        value = chance.choice([value - 1, value + 1, value * 10**9, -value, value[:0], np.repeat(value, 5000)])
    chosen.CopyFrom(numpy_helper.from_array(np.ascontiguousarray(value), chosen.name))


def _constant_lies(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    """A constant whose bytes are not what its shape and type ask for."""
    chosen = chance.choice(model.graph.initializer)
    match chance.choice(["dims", "more dims", "type", "bytes", "name"]):
        case "dims" if chosen.dims:
            chosen.dims[chance.randrange(len(chosen.dims))] = chance.choice(INTEGERS)
        case "more dims":
            chosen.dims.extend([chance.choice([1, 0, LARGE])] * chance.choice([1, 40]))
        case "type":
            chosen.data_type = chance.choice([0, TensorProto.DOUBLE, TensorProto.STRING, TensorProto.INT4, 77])
        case "bytes":
            chosen.raw_data = (chosen.raw_data or bytes(8))[: chance.choice([0, 1, -1])]
        case _:
            chosen.name = chance.choice(["", "x", model.graph.input[0].name])


def _edges(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    """A node that takes or gives another value, or too few, or one of its own."""
    graph = model.graph
    node = chance.choice(graph.node)
    others = ["", "x", *node.output, *(each.name for each in (*graph.input, *graph.initializer))]
    names = chance.choice([node.input, node.output])
    match chance.choice(["other", "other", "fewer", "more"]):
        case "other" if names:
            names[chance.randrange(len(names))] = chance.choice(others)
        case "fewer":
            del names[-1:]
        case _:
            names.append(chance.choice(others))


def _shapes(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    """Inputs, outputs or values in between that are said to be of another type or shape."""
    graph = model.graph
    name = chance.choice([value for node in graph.node for value in node.output if value] or ["x"])
    kind = chance.choice([TensorProto.FLOAT, TensorProto.DOUBLE, TensorProto.INT64, TensorProto.STRING])
    shapes: list[Any] = [[], [0], [1, 1], [LARGE, LARGE], ["n", LARGE], None]
    told = helper.make_tensor_value_info(name, kind, chance.choice(shapes))
    match chance.choice(["input", "output", "value", "more inputs", "no output"]):
        case "input":
            graph.input[0].type.CopyFrom(told.type)
        case "output":
            graph.output[-1].type.CopyFrom(told.type)
        case "value":
            graph.value_info.append(told)
        case "more inputs":
            graph.input.append(told)
        case _:
            del graph.output[-1:]


def _missing(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    model.graph.node.remove(chance.choice(model.graph.node))


def _order(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    nodes = list(model.graph.node)
    chance.shuffle(nodes)
    del model.graph.node[:]
    model.graph.node.extend(nodes)


def _loop(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    body = helper.make_graph([helper.make_node("Identity", ["go"], ["on"])], "b", [], [])
    where = chance.choice([0, len(model.graph.node)])
    model.graph.node.insert(where, helper.make_node(chance.choice(["Loop", "Scan"]), ["", ""], ["never"], body=body))


def _functions(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    """Functions each of which calls the one before it twice: 2^40 calls."""
    depth, opsets = 40, [helper.make_opsetid("", 15), helper.make_opsetid("f", 1)]
    for i in range(depth):
        inner = "Identity" if i == 0 else f"f{i - 1}"
        domain = "" if i == 0 else "f"
        nodes = [helper.make_node(inner, [a], [b], domain=domain) for a, b in (("x", "y"), ("y", "z"))]
        model.functions.append(helper.make_function("f", f"f{i}", ["x"], ["z"], nodes, opsets))
    last = model.graph.node[-1]
    model.graph.node.insert(
        len(model.graph.node) - 1, helper.make_node(f"f{depth - 1}", [last.input[0]], ["called"], domain="f")
    )
    last.input[0] = "called"
    if chance.random() < 0.5:
        model.opset_import.append(helper.make_opsetid("f", 1))


def _grow(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    """Values that are put side by side with themselves: by many nodes, or by one with many inputs."""
    last = model.graph.node[-1]
    first = last.input[0]
    times, wide = chance.choice([(1, 2), (30, 2), (1, 100_000), (2, 30_000), (1, 10)])
    for i in range(times):
        node = helper.make_node("Concat", [first] * wide, [f"g{i}"], axis=1)
        model.graph.node.insert(len(model.graph.node) - 1, node)
        first = f"g{i}"
    last.input[0] = first


def _many_nodes(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    last = model.graph.node[-1]
    value = last.input[0]
    added = []
    for i in range(chance.choice([2000, 9000, 20_000])):
        added.append(helper.make_node("Identity", [value], [f"m{i}"]))
        value = f"m{i}"
    del model.graph.node[-1:]
    model.graph.node.extend(added)
    last.input[0] = value
    model.graph.node.append(last)


def _no_probabilities(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    """The last node makes something else of the scores: no probabilities, or only at some tasks."""
    last = model.graph.node[-1]
    last.op_type = chance.choice(["Relu", "Identity", "Log"])
    del last.attribute[:]


def _external(model: onnx.ModelProto, outside: Path, chance: random.Random) -> None:
    """A constant in another file, beside the map or where the reader runs."""
    tensor = chance.choice(model.graph.initializer)
    (outside / WEIGHTS).write_bytes(numpy_helper.to_array(tensor).tobytes())
    tensor.ClearField("raw_data")
    tensor.ClearField("float_data")
    tensor.ClearField("int64_data")
    tensor.data_location = TensorProto.EXTERNAL
    places = [str(outside / WEIGHTS), f"../{outside.name}/{WEIGHTS}", WEIGHTS, f"./{WEIGHTS}"]
    entry = tensor.external_data.add()
    entry.key, entry.value = "location", chance.choice(places)


WAYS: dict[str, Callable[[onnx.ModelProto, Path, random.Random], None]] = {
    "operator": _operator,
    "domain": _domain,
    "attribute": _attribute,
    "attribute's length": _attribute_length,
    "attribute's type": _attribute_type,
    "attribute missing": _no_attribute,
    "constant": _constant,
    "constant that lies": _constant_lies,
    "edges": _edges,
    "shapes": _shapes,
    "node missing": _missing,
    "order": _order,
    "loop": _loop,
    "functions": _functions,
    "growth": _grow,
    "many nodes": _many_nodes,
    "no probabilities": _no_probabilities,
    "external": _external,
}
