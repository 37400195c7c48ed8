"""What an ONNX file asks to be run, read off its bytes before anything runs.

A graph may hold loops, branches, functions that call each other and products that fill the memory. Classifiers need
none of them, so what may be in a graph is a closed list. The file is protobuf, whose fields are numbered as in
onnx.proto; a dozen of them are needed, for which a planner should not have to install a library.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from math import prod

from gaitflow.runtime.strict import shown

_ELEMENTWISE = frozenset({"Add", "Div", "Mul", "Sub"})
OPERATORS = _ELEMENTWISE | {
    "Cast", "Concat", "Gather", "Gemm", "Identity", "Log", "ReduceMean", "ReduceSum", "Relu", "SVMClassifier", "Scaler",
    "Slice", "Softmax", "TopK", "TreeEnsembleClassifier", "Unsqueeze",
}  # fmt: skip
# Of those that make arrays grow; support vectors of two gaits join arrays twice.
MOST = {"Concat": 2, "Gather": 1, "Sub": 1, "TopK": 1, "Unsqueeze": 1}
MAX_NODES = 10_000
MAX_WIDTH = 4096  # of a constant in every dimension but a matrix' first one, and most values that are joined

# Numbers of fields in onnx.proto.
_MODEL_GRAPH, _MODEL_TRAINING, _MODEL_FUNCTIONS = 7, 20, 25
_GRAPH_NODE, _GRAPH_CONSTANT, _GRAPH_SPARSE = 1, 5, 15
_NODE_INPUT, _NODE_OPERATOR, _NODE_ATTRIBUTE = 1, 4, 5
_ATTRIBUTE_TENSOR, _ATTRIBUTE_GRAPH, _ATTRIBUTE_TENSORS, _ATTRIBUTE_GRAPHS = 5, 6, 10, 11
_CONSTANT_DIMS, _CONSTANT_NAME, _CONSTANT_FILE, _CONSTANT_PLACE = 1, 8, 13, 14


def graph_fault(content: bytes) -> str | None:
    """What in the bytes of an ONNX file no classifier of a map has, in one phrase; None where there is nothing."""
    try:
        return _model_fault(content)
    except (IndexError, ValueError) as error:
        return f"it is no ONNX ({error})"


def _model_fault(content: bytes) -> str | None:
    model = list(_fields(content))
    if any(number in (_MODEL_TRAINING, _MODEL_FUNCTIONS) for number, _ in model):
        return "it holds functions"
    inside = [field for graph in _parts(model, _MODEL_GRAPH) for field in _fields(graph)]
    if any(number == _GRAPH_SPARSE for number, _ in inside):
        return "it holds sparse constants"
    shapes: dict[str, tuple[int, ...]] = {}
    for part in _parts(inside, _GRAPH_CONSTANT):
        name, shape, elsewhere = _constant(part)
        if elsewhere:  # onnxruntime would look for it where it runs
            return f"the constant {name[:80]!r} is kept in another file"
        while shape[:1] == (1,):
            shape = shape[1:]
        if len(shape) > 2 or any(size > MAX_WIDTH for size in shape[len(shape) // 2 :]):
            return f"a constant has the shape {list(shape)[:5]}: more than a matrix, or wider than {MAX_WIDTH}"
        shapes[name] = shape
    return _nodes_fault([list(_fields(part)) for part in _parts(inside, _GRAPH_NODE)], shapes)


def _nodes_fault(nodes: list[list[tuple[int, int | bytes]]], shapes: Mapping[str, tuple[int, ...]]) -> str | None:
    if len(nodes) > MAX_NODES:
        return f"it has {len(nodes)} nodes, more than {MAX_NODES}"
    counts: Counter[str] = Counter()
    for node in nodes:
        operators = [_text(part) for part in _parts(node, _NODE_OPERATOR)]
        if len(operators) != 1 or operators[0] not in OPERATORS:
            return f"the operator {shown(' and '.join(operators)) or 'without a name'} is none that a classifier has"
        counts.update(operators)
        attributes = [number for part in _parts(node, _NODE_ATTRIBUTE) for number, _ in _fields(part)]
        if not {_ATTRIBUTE_TENSOR, _ATTRIBUTE_GRAPH, _ATTRIBUTE_TENSORS, _ATTRIBUTE_GRAPHS}.isdisjoint(attributes):
            return f"{operators[0]} holds a graph or a tensor of its own"
        inputs = [_text(part) for part in _parts(node, _NODE_INPUT)]
        if operators[0] == "Concat" and not len(set(inputs)) == len(inputs) <= MAX_WIDTH:
            return f"Concat joins {len(inputs)} values, one of them twice, or more than {MAX_WIDTH}"
        constants = [shapes.get(name, ()) for name in inputs]
        if operators[0] in _ELEMENTWISE - {"Sub"} and any(prod(shape[:-1]) > 1 for shape in constants):
            return f"{operators[0]} spreads a matrix"
    for operator, most in MOST.items():
        if counts[operator] > most:
            return f"{operator} is there {counts[operator]} times; a classifier needs {most}"
    return None


def _constant(part: bytes) -> tuple[str, tuple[int, ...], bool]:
    """Name and shape of a TensorProto, and whether its numbers are said to be in another file."""
    name, shape, elsewhere = "", list[int](), False
    for number, value in _fields(part):
        if number == _CONSTANT_NAME and isinstance(value, bytes):
            name = _text(value)
        elif number == _CONSTANT_DIMS:
            shape += [value] if isinstance(value, int) else _packed(value)
        elif number == _CONSTANT_FILE or (number == _CONSTANT_PLACE and value != 0):
            elsewhere = True
    return name, tuple(shape), elsewhere


def _parts(fields: list[tuple[int, int | bytes]], number: int) -> Iterator[bytes]:
    """The values of a field of bytes, every time that it is given."""
    for found, value in fields:
        if found == number:
            if not isinstance(value, bytes):
                raise ValueError(f"field {number} is a number")
            yield value


def _fields(message: bytes) -> Iterator[tuple[int, int | bytes]]:
    """The fields of a protobuf message by number, as integers or bytes. Raises ValueError, IndexError."""
    at = 0
    while at < len(message):
        key, at = _varint(message, at)
        kind = key & 7
        if kind == 0:
            value, at = _varint(message, at)
            yield key >> 3, value
            continue
        size, start = {1: (8, at), 5: (4, at)}.get(kind) or (_varint(message, at) if kind == 2 else (-1, at))
        at = start + size
        if size < 0 or at > len(message):
            raise ValueError("a field ends beyond it")
        yield key >> 3, message[start:at]


def _packed(message: bytes) -> list[int]:
    found, at = list[int](), 0
    while at < len(message):
        value, at = _varint(message, at)
        found.append(value)
    return found


def _varint(message: bytes, at: int) -> tuple[int, int]:
    """The integer that begins at a place, and where it ends."""
    value = 0
    for shift in range(0, 70, 7):
        byte = message[at]
        at += 1
        value |= (byte & 127) << shift
        if byte < 128:
            return value, at
    raise ValueError("an integer is too long")


def _text(part: bytes) -> str:
    return part.decode("utf-8", "replace")
