"""Every method says through onnxruntime what it says in memory."""

from __future__ import annotations

import numpy as np
import onnx
import onnxruntime
import pytest
from onnx import numpy_helper

from gaitflow.config.scenario import Learning
from gaitflow.learn.classifier import GaitClassifier, frequencies_of
from gaitflow.learn.export_onnx import to_onnx_bytes
from gaitflow.learn.methods import methods

RANDOM = np.random.default_rng(0)
LOW, HIGH = (0.1, 0.4, -20.0), (2.3, 1.6, 20.0)
ALL_TASKS = RANDOM.uniform(LOW, HIGH, (60, 3)).astype(np.float32)
ALL_QUERIES = RANDOM.uniform(LOW, HIGH, (300, 3)).astype(np.float32)
TASKS, QUERIES = ALL_TASKS[:, :2], ALL_QUERIES[:, :2]
TEMPERATURE = 1.7
NAMES = ("mlp", "svm", "forest", "knn")


def fitted(name: str, classes: int, learning: Learning, axes: int = 2) -> GaitClassifier:
    tasks = ALL_TASKS[:, :axes]
    score = tasks[:, 0] - 0.5 * (tasks[:, 1] if axes > 1 else 0.8)
    y = np.digitize(score, np.linspace(-0.2, 1.4, classes - 1)).astype(np.int64)
    assert set(y) == set(range(classes))
    method = next(method for method in methods(learning, axes, classes, 30) if method.name == name)
    pipeline = method.pipeline.fit(tasks, y)
    labels = tuple("abcdefgh"[:classes])
    return GaitClassifier(name, labels, pipeline, frequencies_of(y, classes), TEMPERATURE)


def run(model: bytes, tasks: np.ndarray) -> np.ndarray:
    session = onnxruntime.InferenceSession(model, providers=["CPUExecutionProvider"])
    assert [value.name for value in session.get_outputs()] == ["probability"]
    (probability,) = session.run(None, {"task": tasks})
    return np.asarray(probability)


@pytest.mark.parametrize("classes", [2, 4])
@pytest.mark.parametrize("name", NAMES)
def test_an_exported_model_agrees_with_the_one_in_memory(name: str, classes: int, learning: Learning) -> None:
    classifier = fitted(name, classes, learning)
    found = run(to_onnx_bytes(classifier), QUERIES)
    assert found.dtype == np.float32
    assert found.shape == (300, classes)
    expected = classifier.probabilities(QUERIES)
    # A threshold of a tree, or two tasks equally far, may fall on the other side in float32: a handful of queries.
    away_from_ties = np.abs(found - expected).max(axis=1) <= 1e-5
    assert away_from_ties.mean() >= (1.0 if name in ("mlp", "svm") else 0.99)
    np.testing.assert_allclose(found.sum(axis=1), 1.0, atol=1e-5)
    assert len(set(expected.argmax(axis=1))) == classes


@pytest.mark.parametrize("axes", [1, 3])
@pytest.mark.parametrize("name", NAMES)
def test_a_model_has_an_input_for_each_axis(name: str, axes: int, learning: Learning) -> None:
    classifier = fitted(name, 3, learning, axes)
    found = run(to_onnx_bytes(classifier), ALL_QUERIES[:, :axes])
    expected = classifier.probabilities(ALL_QUERIES[:, :axes])
    assert (np.abs(found - expected).max(axis=1) <= 1e-5).mean() >= 0.98


@pytest.mark.parametrize("name", NAMES)
def test_one_query_gets_the_answer_it_gets_in_a_batch(name: str, learning: Learning) -> None:
    model = to_onnx_bytes(fitted(name, 3, learning))
    np.testing.assert_allclose(run(model, QUERIES[:1]), run(model, QUERIES)[:1], atol=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_weights_are_float32_and_equal_classifiers_give_equal_bytes(name: str, learning: Learning) -> None:
    model = to_onnx_bytes(fitted(name, 3, learning))
    graph = onnx.load_model_from_string(model).graph
    kinds = {numpy_helper.to_array(tensor).dtype.name for tensor in graph.initializer}
    assert "float32" in kinds
    assert "float64" not in kinds
    assert to_onnx_bytes(fitted(name, 3, learning)) == model
