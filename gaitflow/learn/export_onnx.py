"""A gait classifier as ONNX, everything folded in: raw task in, calibrated probability out, float32 throughout."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper
from onnx.utils import Extractor
from scipy.linalg import block_diag
from skl2onnx import to_onnx
from skl2onnx.common.data_types import FloatTensorType
from sklearn.dummy import DummyClassifier
from sklearn.ensemble import RandomForestClassifier
from sklearn.neighbors import KNeighborsClassifier

from gaitflow.learn.classifier import SMOOTHING, GaitClassifier
from gaitflow.learn.methods import MLP
from gaitflow.learn.mirror import MirrorImages

INPUT = "task"  # float32 [n, axes]: values on the axes with a range
OUTPUT = "probability"  # float32 [n, classes]
OPSET = 15
ML_OPSET = 3
IR_VERSION = 8  # the oldest that goes with these operator sets, so that older runtimes read it too

Layer = tuple[NDArray[np.floating], NDArray[np.floating]]  # weights [outputs, inputs] and biases [outputs]


def to_onnx_bytes(classifier: GaitClassifier) -> bytes:
    """The classifier as a serialised ONNX model: INPUT -> OUTPUT, the scaler and the temperature within.

    Raises ValueError when a weight would not be float32, which onnx.checker lets pass and onnxruntime refuses.
    """
    estimator = classifier.pipeline[-1]
    if classifier.method == MLP:
        graph = _perceptron_graph(_layers(classifier))
    elif isinstance(estimator, DummyClassifier):
        graph = _perceptron_graph([(np.zeros((1, classifier.inputs)), np.zeros(1))])  # softmax of one score is 1
    elif isinstance(estimator, KNeighborsClassifier):
        graph = _neighbours_graph(classifier)
    else:
        graph = _converted_graph(classifier)
    _append_calibration(graph, classifier)
    opsets = [helper.make_opsetid("", OPSET), helper.make_opsetid("ai.onnx.ml", ML_OPSET)]
    model = helper.make_model(graph, opset_imports=opsets, ir_version=IR_VERSION, producer_name="gaitflow")
    onnx.checker.check_model(model, full_check=True)
    for tensor in graph.initializer:
        if tensor.data_type == TensorProto.DOUBLE:
            raise ValueError(f"{classifier.method}: the weight {tensor.name} is float64; export it as float32")
    return bytes(model.SerializeToString(deterministic=True))


def _layers(classifier: GaitClassifier) -> list[Layer]:
    """The perceptron's layers, the first of them taking raw tasks: W (x - mean) / scale = (W / scale) x - ..."""
    scaler, module = classifier.pipeline[0], classifier.pipeline[-1].module_
    state = [tensor.double().numpy() for tensor in module.state_dict().values()]
    layers = list(zip(state[::2], state[1::2], strict=True))
    if module.images is not None:
        layers = _with_images(layers, module.images)
    weights, biases = layers[0]
    weights = weights / scaler.scale_
    return [(weights, biases - weights @ scaler.mean_), *layers[1:]]


def _with_images(layers: Sequence[Layer], images: MirrorImages) -> list[Layer]:
    """One perceptron, twice as wide, that gives the mean of the scores of a task and of its mirror image."""
    (first, bias), *middle, (last, last_bias) = layers
    of_images = list(images.classes)
    return [
        (np.vstack([first, first * np.array(images.signs)]), np.tile(bias, 2)),
        *((block_diag(weights, weights), np.tile(biases, 2)) for weights, biases in middle),
        (np.hstack([last, last[of_images]]) / 2, (last_bias + last_bias[of_images]) / 2),
    ]


def _perceptron_graph(layers: Sequence[Layer]) -> onnx.GraphProto:
    nodes, weights, value = [], [], INPUT
    for i, (weight, bias) in enumerate(layers):
        last = i == len(layers) - 1
        total = "scores" if last else f"sum_{i}"
        nodes.append(helper.make_node("Gemm", [value, f"weight_{i}", f"bias_{i}"], [total], transB=1))
        weights += [_float32(f"weight_{i}", weight), _float32(f"bias_{i}", bias)]
        if not last:
            nodes.append(helper.make_node("Relu", [total], [f"hidden_{i}"]))
            value = f"hidden_{i}"
    outputs = [helper.make_tensor_value_info("scores", TensorProto.FLOAT, [None, len(layers[-1][1])])]
    return helper.make_graph(nodes, "gait", [_input(layers[0][0].shape[1])], outputs, weights)


def _neighbours_graph(classifier: GaitClassifier) -> onnx.GraphProto:
    """Votes of the k nearest tasks, by hand: skl2onnx numbers its names by what the process converted before.

    Both sides of the distance are raw tasks divided by the scale, so the mean cancels.
    """
    scaler, estimator = classifier.pipeline
    known = (estimator._fit_X + scaler.mean_ / scaler.scale_)[np.newaxis]
    nodes = [
        helper.make_node("Div", [INPUT, "scale"], ["scaled"]),
        helper.make_node("Unsqueeze", ["scaled", "middle"], ["query"]),
        helper.make_node("Sub", ["query", "known"], ["difference"]),
        helper.make_node("Mul", ["difference", "difference"], ["square"]),
        helper.make_node("ReduceSum", ["square", "last"], ["distance"], keepdims=0),
        helper.make_node("TopK", ["distance", "k"], ["nearest", "index"], largest=0),
        helper.make_node("Gather", ["ballots", "index"], ["ballot"]),
        helper.make_node("ReduceMean", ["ballot"], ["votes"], axes=[1], keepdims=0),
    ]
    weights = [
        _float32("scale", scaler.scale_),
        _float32("known", known),
        _float32("ballots", np.eye(len(classifier.classes))[estimator._y]),
        numpy_helper.from_array(np.array([1]), "middle"),
        numpy_helper.from_array(np.array([-1]), "last"),
        numpy_helper.from_array(np.array([estimator.n_neighbors]), "k"),
    ]
    graph = helper.make_graph(nodes, "gait", [_input(classifier.inputs)], [], weights)
    _append_log_of_votes(graph, classifier)
    return graph


def _converted_graph(classifier: GaitClassifier) -> onnx.GraphProto:
    """What skl2onnx makes of the SVM or the forest, without its label: the output is decision values or votes."""
    estimator = classifier.pipeline[-1]
    votes = isinstance(estimator, RandomForestClassifier)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Attribute `prob[AB]_` was deprecated", FutureWarning)  # read, not used
        model = to_onnx(
            classifier.pipeline,
            initial_types=[(INPUT, FloatTensorType([None, classifier.inputs]))],
            options={id(estimator): {"zipmap": False} | ({} if votes else {"raw_scores": True})},
            target_opset={"": OPSET, "ai.onnx.ml": ML_OPSET},
        )
    kept = model.graph.output[1].name
    graph: onnx.GraphProto = Extractor(model).extract_model([INPUT], [kept]).graph
    graph.node.append(helper.make_node("Identity", [kept], ["votes" if votes else "scores"]))
    if votes:
        _append_log_of_votes(graph, classifier)
    return graph


def _append_log_of_votes(graph: onnx.GraphProto, classifier: GaitClassifier) -> None:
    graph.initializer.append(_float32("smoothing", SMOOTHING * np.asarray(classifier.frequencies)))
    graph.node.append(helper.make_node("Add", ["votes", "smoothing"], ["smoothed"]))
    graph.node.append(helper.make_node("Log", ["smoothed"], ["scores"]))


def _append_calibration(graph: onnx.GraphProto, classifier: GaitClassifier) -> None:
    graph.initializer.append(_float32("temperature", np.asarray(classifier.temperature)))
    graph.node.append(helper.make_node("Div", ["scores", "temperature"], ["calibrated"]))
    graph.node.append(helper.make_node("Softmax", ["calibrated"], [OUTPUT], axis=1))
    del graph.output[:]
    shape = [None, len(classifier.classes)]
    graph.output.append(helper.make_tensor_value_info(OUTPUT, TensorProto.FLOAT, shape))


def _input(axes: int) -> onnx.ValueInfoProto:
    return helper.make_tensor_value_info(INPUT, TensorProto.FLOAT, [None, axes])


def _float32(name: str, values: NDArray[np.floating]) -> TensorProto:
    return numpy_helper.from_array(np.ascontiguousarray(values, dtype=np.float32), name)
