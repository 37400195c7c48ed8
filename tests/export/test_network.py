"""A perceptron becomes layers that answer as onnxruntime does; anything else is refused by its name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
import pytest

from gaitflow.config.scenario import Learning
from gaitflow.export.network import CannotExport, Network, read_network
from gaitflow.learn.classifier import GaitClassifier, frequencies_of
from gaitflow.learn.export_onnx import to_onnx_bytes
from gaitflow.learn.methods import methods
from gaitflow.runtime.classifier import Classifier
from gaitflow.runtime.manifest_file import read_manifest

LEARNING = Learning(folds=2, hidden_layers=((12, 8, 6),), learning_rates=(1e-2,), max_epochs=20)
TASKS = np.random.default_rng(0).uniform((0.1, 0.4), (2.3, 1.6), (60, 2)).astype(np.float32)


def fitted(name: str) -> bytes:
    y = np.digitize(TASKS @ [1.0, -0.5], [0.2, 0.9]).astype(np.int64)
    method = next(method for method in methods(LEARNING, 2, 3, 30) if method.name == name)
    pipeline = method.pipeline.fit(TASKS, y)
    return to_onnx_bytes(GaitClassifier(name, ("a", "b", "c"), pipeline, frequencies_of(y, 3), 1.7))


def evaluated(network: Network, tasks: np.ndarray) -> np.ndarray:
    values = tasks
    for layer in network.layers:
        values = values @ layer.weights.T + layer.biases
        if layer is not network.layers[-1]:
            values = np.maximum(values, 0)
    scores = np.exp(values / network.temperature - (values / network.temperature).max(axis=1, keepdims=True))
    return scores / scores.sum(axis=1, keepdims=True)


def test_the_layers_answer_as_the_graph_does() -> None:
    content = fitted("mlp")
    network = read_network(content, "mlp", "classifier.onnx")
    assert [layer.weights.shape for layer in network.layers] == [(12, 2), (8, 12), (6, 8), (3, 6)]
    assert network.temperature == pytest.approx(1.7)
    np.testing.assert_allclose(evaluated(network, TASKS), Classifier(content, 2, 3, "here")(TASKS), atol=1e-5)


def test_a_published_classifier_can_be_read(checkout: Path) -> None:
    folder = checkout / "models/half-cheetah-flat-effort/1.0.0"
    gaits, content = len(read_manifest(folder).gaits), (folder / "classifier.onnx").read_bytes()
    network = read_network(content, "mlp", "here")
    np.testing.assert_allclose(evaluated(network, TASKS), Classifier(content, 2, gaits, "here")(TASKS), atol=1e-5)


@pytest.mark.parametrize("name", ["svm", "forest", "knn"])
def test_another_kind_is_refused_by_its_name_with_a_way_out(name: str) -> None:
    with pytest.raises(CannotExport, match=rf"m/classifier.onnx: .* kind '{name}'.*mlp.*ONNX Runtime"):
        read_network(fitted(name), name, "m/classifier.onnx")


def changed(content: bytes, change: str) -> bytes:
    model = onnx.load_model_from_string(content)
    gemm, relu, softmax = model.graph.node[0], model.graph.node[1], model.graph.node[-1]
    if change == "axis":
        softmax.attribute[0].i = 0
    elif change == "alpha":
        gemm.attribute.append(onnx.helper.make_attribute("alpha", 2.0))
    elif change == "unchained":
        relu.input[0] = "task"
    elif change == "no constant":
        gemm.input[1] = "elsewhere"
    elif change == "temperatures":
        tensor = onnx.numpy_helper.from_array(np.ones(3, dtype=np.float32), "temperature")
        next(each for each in model.graph.initializer if each.name == "temperature").CopyFrom(tensor)
    return model.SerializeToString()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ("axis", "axis = 0 of Softmax"),
        ("alpha", "alpha = 2.0 of Gemm"),
        ("unchained", "a graph of Gemm Relu"),
        ("no constant", "no float32 constant: 'elsewhere'"),
        ("temperatures", "divided by 3 numbers"),
    ],
)
def test_a_graph_that_means_something_else_is_refused(change: str, says: str) -> None:
    with pytest.raises(CannotExport, match=says):
        read_network(changed(fitted("mlp"), change), "mlp", "here")
