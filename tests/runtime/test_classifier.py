from __future__ import annotations

import numpy as np
import pytest
from onnx import TensorProto, helper, numpy_helper

from gaitflow.runtime import ArtifactError
from gaitflow.runtime.classifier import Classifier


def graph(
    output: str = "probability", kind: int = TensorProto.FLOAT, columns: int = 3, op: str = "MatMul", external: str = ""
) -> bytes:
    weights = numpy_helper.from_array(np.ones((2, columns), helper.tensor_dtype_to_np_dtype(kind)), "weights")
    if external:
        weights.ClearField("raw_data")
        weights.data_location = TensorProto.EXTERNAL
        entry = weights.external_data.add()
        entry.key, entry.value = "location", external
    made = helper.make_graph(
        [helper.make_node(op, ["task", "weights"], [output])],
        "g",
        [helper.make_tensor_value_info("task", kind, [None, 2])],
        [helper.make_tensor_value_info(output, kind, [None, columns])],
        [weights],
    )
    return helper.make_model(made, opset_imports=[helper.make_opsetid("", 15)], ir_version=8).SerializeToString()


def test_answers_any_number_of_tasks() -> None:
    classifier = Classifier(graph(), 2, 3, "c")
    assert classifier(np.array([[1, 2], [3, 4]], dtype=np.float32)).tolist() == [[3, 3, 3], [7, 7, 7]]


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        (graph(output="scores"), "the output 'probability', found"),
        (graph(kind=TensorProto.DOUBLE), "expected one float32 input"),
        (graph(columns=2), r"shape \(1, 3\), found \(1, 2\)"),
        (graph(op="NoSuchOperator"), "cannot load it"),
        (b"garbage", "cannot load it"),
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
        with pytest.raises(ArtifactError, match="cannot load it"):
            Classifier(graph(external=location), 2, 3, "c")
