"""A classifier becomes numbers, whichever method won; a graph that means something else is refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import onnx
import pytest
from onnx import numpy_helper
from trained import NAMES, fitted, grid_tasks

from gaitflow.export.classifier_data import ClassifierData, read_classifier
from gaitflow.export.forest import Forest
from gaitflow.export.graph import CannotExport
from gaitflow.export.neighbours import Neighbours
from gaitflow.export.perceptron import Perceptron
from gaitflow.export.support_vectors import SupportVectors
from gaitflow.runtime.classifier import Classifier
from gaitflow.runtime.manifest_file import read_manifest

METHODS = {"mlp": Perceptron, "forest": Forest, "svm": SupportVectors, "knn": Neighbours}
TASKS = np.random.default_rng(0).uniform((0.1, 0.4), (2.3, 1.6), (60, 2)).astype(np.float32)


def evaluated(data: ClassifierData, tasks: np.ndarray) -> np.ndarray:
    assert isinstance(data.method, Perceptron)
    values = tasks
    for layer in data.method.layers:
        values = values @ layer.weights.T + layer.biases
        if layer is not data.method.layers[-1]:
            values = np.maximum(values, 0)
    scores = np.exp(values / data.temperature - (values / data.temperature).max(axis=1, keepdims=True))
    return scores / scores.sum(axis=1, keepdims=True)


def test_the_layers_answer_as_the_graph_does() -> None:
    content = fitted("mlp", 3)
    data = read_classifier(content, "mlp", "classifier.onnx")
    assert isinstance(data.method, Perceptron)
    assert [layer.weights.shape for layer in data.method.layers] == [(12, 2), (8, 12), (6, 8), (3, 6)]
    assert data.temperature == pytest.approx(1.7)
    np.testing.assert_allclose(evaluated(data, TASKS), Classifier(content, 2, 3, "here")(TASKS), atol=1e-5)


@pytest.mark.parametrize("name", NAMES)
def test_every_method_becomes_its_kind_of_data(name: str) -> None:
    data = read_classifier(fitted(name, 4), name, "here")
    assert type(data.method) is METHODS[name]
    assert len(data.smoothing) == (4 if name in ("forest", "knn") else 0)
    assert data.temperature == pytest.approx(1.7)


def test_two_gaits_have_one_column_of_votes_and_one_machine() -> None:
    forest, machines = (read_classifier(fitted(name, 2), name, "here").method for name in ("forest", "svm"))
    assert isinstance(forest, Forest) and forest.votes.shape[1] == 1
    assert isinstance(machines, SupportVectors) and len(machines.machines) == 1


def test_the_nodes_of_a_forest_lead_forward() -> None:
    forest = read_classifier(fitted("forest", 4), "forest", "here").method
    assert isinstance(forest, Forest) and len(forest.roots) == 100
    assert (np.minimum(forest.below, forest.above) > np.arange(len(forest.axis))).all()
    reached = np.concatenate([forest.roots, forest.below, forest.above])
    assert sorted(reached) == list(range(len(forest.axis) + len(forest.votes))), "each node and leaf once"
    np.testing.assert_allclose(forest.votes.sum(axis=1), 0.01, rtol=1e-6)


def test_the_known_tasks_are_those_it_was_fitted_to() -> None:
    neighbours = read_classifier(fitted("knn", 4), "knn", "here").method
    assert isinstance(neighbours, Neighbours)
    np.testing.assert_allclose(neighbours.known * neighbours.scale, grid_tasks(2), rtol=1e-5)
    assert np.bincount(neighbours.gait).tolist() == [15, 15, 15, 15]


def test_every_published_classifier_can_be_read(checkout: Path) -> None:
    kinds = set()
    for path in sorted((checkout / "models").glob("*/*/classifier.onnx")):
        kind = read_manifest(path.parent).classifier_kind
        assert isinstance(read_classifier(path.read_bytes(), kind, str(path)).method, METHODS[kind])
        kinds.add(kind)
    assert kinds == set(METHODS)


def node(graph: onnx.GraphProto, operator: str) -> onnx.NodeProto:
    return next(each for each in graph.node if each.op_type == operator)


def attribute(graph: onnx.GraphProto, operator: str, name: str) -> onnx.AttributeProto:
    return next(each for each in node(graph, operator).attribute if each.name == name)


def constant(graph: onnx.GraphProto, name: str, values: object) -> None:
    tensor = next(each for each in graph.initializer if each.name == name)
    kind = numpy_helper.to_array(tensor).dtype
    tensor.CopyFrom(numpy_helper.from_array(np.array(values, dtype=kind), name))


Change = Callable[[onnx.GraphProto], object]

CHANGES: list[tuple[str, Change, str]] = [
    ("mlp", lambda graph: setattr(attribute(graph, "Softmax", "axis"), "i", 0), "axis = 0 of Softmax"),
    (
        "mlp",
        lambda graph: node(graph, "Gemm").attribute.append(onnx.helper.make_attribute("alpha", 2.0)),
        "alpha = 2.0 of Gemm",
    ),
    ("mlp", lambda graph: setattr(node(graph, "Relu"), "op_type", "Tanh"), "comes from Tanh, not from Relu"),
    ("mlp", lambda graph: node(graph, "Relu").input.__setitem__(0, "task"), "'task' comes from no node, not from Gemm"),
    ("mlp", lambda graph: node(graph, "Gemm").input.__setitem__(1, "far"), "input 1 of Gemm is no float32 .*'far'"),
    ("mlp", lambda graph: constant(graph, "temperature", [1, 2, 3]), r"divided by \[1.0, 2.0, 3.0\]"),
    ("mlp", lambda graph: constant(graph, "temperature", [-1]), r"divided by \[-1.0\]"),
    ("mlp", lambda graph: constant(graph, "bias_0", [np.nan] * 12), "input 2 of Gemm holds numbers that are not fin"),
    ("mlp", lambda graph: constant(graph, "bias_0", [1.0]), r"weights \(12, 2\) and biases \(1,\) do not fit"),
    ("forest", lambda graph: constant(graph, "smoothing", [0.0] * 4), "smoothed by .*, not by a positive number"),
    (
        "forest",
        lambda graph: setattr(attribute(graph, "TreeEnsembleClassifier", "post_transform"), "s", b"SOFTMAX"),
        "post_transform = b'SOFTMAX' of TreeEnsembleClassifier",
    ),
    (
        "forest",
        lambda graph: attribute(graph, "TreeEnsembleClassifier", "nodes_modes").strings.__setitem__(0, b"BRANCH_GT"),
        "node 0 of tree 0 is of mode 'BRANCH_GT'",
    ),
    (
        "forest",
        lambda graph: attribute(graph, "TreeEnsembleClassifier", "nodes_truenodeids").ints.__setitem__(0, 0),
        "node 0 of tree 0 is missing or reached twice",
    ),
    (
        "forest",
        lambda graph: attribute(graph, "TreeEnsembleClassifier", "nodes_featureids").ints.__setitem__(0, 2),
        "asks for an axis that there is not",
    ),
    (
        "forest",
        lambda graph: attribute(graph, "TreeEnsembleClassifier", "class_ids").ints.__setitem__(0, 4),
        "votes .* for class 4 of 4",
    ),
    (
        "forest",
        lambda graph: attribute(graph, "TreeEnsembleClassifier", "nodes_values").floats.pop(),
        "columns of its trees are not equally long",
    ),
    ("forest", lambda graph: attribute(graph, "Scaler", "offset").floats.pop(), "1 offsets and 2 scales"),
    ("forest", lambda graph: node(graph, "Scaler").input.__setitem__(0, "elsewhere"), "it begins with 'elsewhere'"),
    (
        "svm",
        lambda graph: setattr(attribute(graph, "SVMClassifier", "kernel_type"), "s", b"POLY"),
        "kernel_type = b'POLY' of SVMClassifier",
    ),
    ("svm", lambda graph: attribute(graph, "SVMClassifier", "rho").floats.append(1.0), "a machine of .* coefficients"),
    (
        "svm",
        lambda graph: attribute(graph, "SVMClassifier", "vectors_per_class").ints.__setitem__(0, 1),
        "other vectors than its classes have",
    ),
    ("svm", lambda graph: constant(graph, "starts", [0]), r"the slice \[\[0\], \[2\], \[0\]\]"),
    ("svm", lambda graph: constant(graph, "minus_one", 1.0), "scores are not taken times -1"),
    ("knn", lambda graph: setattr(attribute(graph, "TopK", "largest"), "i", 1), "largest = 1 of TopK"),
    ("knn", lambda graph: constant(graph, "k", [61]), r"the nearest \[61\] of 60 tasks"),
    ("knn", lambda graph: constant(graph, "last", [0]), "distances are not Euclidean"),
    ("knn", lambda graph: constant(graph, "ballots", np.full((60, 4), 0.25)), "has not one vote for one gait"),
    ("knn", lambda graph: constant(graph, "scale", [1.0]), r"tasks \(1, 60, 2\) and ballots \(60, 4\) do not fit"),
]


@pytest.mark.parametrize(("name", "change", "says"), CHANGES, ids=[f"{name}: {says}" for name, _, says in CHANGES])
def test_a_graph_that_means_something_else_is_refused(name: str, change: Change, says: str) -> None:
    model = onnx.load_model_from_string(fitted(name, 4))
    change(model.graph)
    with pytest.raises(CannotExport, match=f"m/classifier.onnx: .* kind {name!r}.*: .*{says}.*ONNX Runtime"):
        read_classifier(model.SerializeToString(), name, "m/classifier.onnx")
