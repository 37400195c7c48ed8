from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
import pytest
from onnx import ModelProto, NodeProto, TensorProto, helper, numpy_helper

from gaitflow.runtime import ArtifactError
from gaitflow.runtime.classifier import Classifier

OPSETS = [helper.make_opsetid("", 15), helper.make_opsetid("f", 1)]
SCORES = helper.make_node("Gemm", ["task", "weights"], ["scores"])
SOFTMAX = helper.make_node("Softmax", ["scores"], ["probability"], axis=1)


def model(
    *nodes: NodeProto,
    output: str = "probability",
    kind: int = TensorProto.FLOAT,
    columns: int = 3,
    external: str = "",
    functions: Sequence[object] = (),
    **constants: np.ndarray,
) -> ModelProto:
    weights = numpy_helper.from_array(np.ones((2, columns), helper.tensor_dtype_to_np_dtype(kind)), "weights")
    if external:
        weights.ClearField("raw_data")
        weights.data_location = TensorProto.EXTERNAL
        entry = weights.external_data.add()
        entry.key, entry.value = "location", external
    made = helper.make_graph(
        nodes or [SCORES, helper.make_node("Softmax", ["scores"], [output], axis=1)],
        "g",
        [helper.make_tensor_value_info("task", kind, [None, 2])],
        [helper.make_tensor_value_info(output, kind, [None, columns])],
        [weights, *(numpy_helper.from_array(value, name) for name, value in constants.items())],
    )
    return helper.make_model(made, opset_imports=OPSETS, ir_version=8, functions=list(functions))


def graph(*nodes: NodeProto, **others: object) -> bytes:
    return model(*nodes, **others).SerializeToString()


def endless_loop() -> NodeProto:
    """10^12 turns that do nothing."""
    body = helper.make_graph(
        [helper.make_node("Identity", ["go"], ["on"]), helper.make_node("Identity", ["value"], ["same"])],
        "body",
        [
            helper.make_tensor_value_info("turn", TensorProto.INT64, []),
            helper.make_tensor_value_info("go", TensorProto.BOOL, []),
            helper.make_tensor_value_info("value", TensorProto.FLOAT, None),
        ],
        [
            helper.make_tensor_value_info("on", TensorProto.BOOL, []),
            helper.make_tensor_value_info("same", TensorProto.FLOAT, None),
        ],
    )
    return helper.make_node("Loop", ["turns", "yes", "scores"], ["looped"], body=body)


def calling_itself_twice(depth: int) -> list[object]:
    """Functions f0, f1, ... each of which calls the one before it twice: 2^depth calls."""
    made = []
    for i in range(depth):
        called = ("Relu", "") if i == 0 else (f"f{i - 1}", "f")
        nodes = [
            helper.make_node(called[0], ["x"], ["y"], domain=called[1]),
            helper.make_node(called[0], ["y"], ["z"], domain=called[1]),
        ]
        made.append(helper.make_function("f", f"f{i}", ["x"], ["z"], nodes, OPSETS))
    return made


def test_answers_any_number_of_tasks() -> None:
    classifier = Classifier(graph(weights_=np.zeros(1)), 2, 3, "c")
    assert classifier(np.array([[1, 2], [3, 4]], dtype=np.float32)) == pytest.approx(np.full((2, 3), 1 / 3))


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        (graph(output="scores_"), "the output 'probability', found"),
        (graph(kind=TensorProto.DOUBLE), "expected one float32 input"),
        (graph(output="a\n\x1b[31m"), r"found 'a\\n\\x1b\[31m'"),
        (graph(columns=2), r"shape \(1, 3\), found \(1, 2\)"),
        (graph(helper.make_node("NoSuchOperator", ["task"], ["probability"])), "NoSuchOperator is none"),
        (graph(helper.make_node("a\nb", ["task"], ["probability"])), r"the operator 'a\\nb' is none"),
        (b"garbage", "it is no ONNX"),
        (b"", "cannot load it"),
    ],
)
def test_other_graphs_are_refused(content: bytes, fault: str) -> None:
    with pytest.raises(ArtifactError, match=f"^c: .*{fault}"):
        Classifier(content, 2, 3, "c")


def test_a_graph_of_another_number_of_axes_is_refused() -> None:
    with pytest.raises(ArtifactError, match=r"^c: the classifier failed"):
        Classifier(graph(), 3, 3, "c")


def test_a_graph_cannot_read_other_files(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "secret.bin").write_bytes(np.ones((2, 3), np.float32).tobytes())
    monkeypatch.chdir(tmp_path)
    for location in ("secret.bin", "./secret.bin", str(tmp_path / "secret.bin"), f"../{tmp_path.name}/secret.bin"):
        with pytest.raises(ArtifactError, match=r"^c: the constant 'weights' is kept in another file"):
            Classifier(graph(external=location), 2, 3, "c")


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        (
            graph(
                SCORES,
                endless_loop(),
                helper.make_node("Softmax", ["looped"], ["probability"], axis=1),
                turns=np.array(10**12),
                yes=np.array(True),
            ),
            "the operator Loop is none that a classifier has",
        ),
        (
            graph(
                SCORES,
                helper.make_node("f39", ["scores"], ["called"], domain="f"),
                helper.make_node("Softmax", ["called"], ["probability"], axis=1),
                functions=calling_itself_twice(40),
            ),
            "it holds functions",
        ),
        (
            graph(
                SCORES,
                *(
                    helper.make_node("Concat", [f"s{i}" if i else "task", "scores"], [f"s{i + 1}"], axis=1)
                    for i in range(40)
                ),
                helper.make_node("Softmax", ["s40"], ["probability"], axis=1),
            ),
            "Concat is there 40 times; a classifier needs 2",
        ),
        (
            graph(
                SCORES,
                helper.make_node("Add", ["scores", "tower"], ["wide"]),
                SOFTMAX,
                tower=np.ones((100_000, 1), np.float32),
            ),
            "Add spreads a matrix",
        ),
        (graph(SCORES, SOFTMAX, wide=np.ones(5000, np.float32)), r"a constant has the shape \[5000\]"),
        (
            graph(
                SCORES,
                helper.make_node("Concat", ["scores"] * 100_000, ["joined"], axis=1),
                helper.make_node("Softmax", ["joined"], ["probability"], axis=1),
            ),
            "Concat joins 100000 values, one of them twice",
        ),
    ],
    ids=["loop", "functions", "doubling", "spreading", "wide", "joining"],
)
def test_a_graph_that_takes_for_ever_or_all_memory_is_refused_before_it_runs(content: bytes, fault: str) -> None:
    start = time.monotonic()
    with pytest.raises(ArtifactError, match=f"^c: {fault}"):
        Classifier(content, 2, 3, "c")
    assert time.monotonic() - start < 2


@pytest.mark.parametrize(
    "probabilities", [[1.5, -0.5, 0.0], [5.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.2, 0.2, 0.2]], ids=str
)
def test_what_is_no_probability_is_refused(probabilities: list[float]) -> None:
    nodes = [
        helper.make_node("Mul", ["scores", "nothing"], ["zeros"]),
        helper.make_node("Add", ["zeros", "wanted"], ["probability"]),
    ]
    constants = {"nothing": np.zeros(1, np.float32), "wanted": np.array(probabilities, np.float32)}
    with pytest.raises(ArtifactError, match="its probabilities are not at least 0 with sum 1"):
        Classifier(graph(SCORES, *nodes, **constants), 2, 3, "c")


def test_what_is_no_probability_at_some_task_alone_is_refused_there() -> None:
    """Logarithms of negative numbers are NaN, and those of large ones add up to more than 1."""
    nodes = [helper.make_node("Log", ["scores"], ["logs"]), helper.make_node("Mul", ["logs", "third"], ["probability"])]
    third = np.full(1, 1 / 3 / np.log(2), np.float32)
    classifier = Classifier(graph(SCORES, *nodes, third=third), 2, 3, "c")
    good = np.ones((1, 2), np.float32)
    assert classifier(good) == pytest.approx(np.full((1, 3), 1 / 3))
    for bad in (-1.0, 50.0):
        for rows in (bad * good, np.concatenate([good, bad * good])):
            with pytest.raises(ArtifactError, match="its probabilities are not at least 0 with sum 1"):
                classifier(rows)
