"""The small real map, exported: as it is, and with a perceptron and an atlas that has more to choose from."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from onnx import TensorProto, helper, numpy_helper
from tiny_map import artifact, parts, pristine

from gaitflow.export import Exported, export_c
from gaitflow.publishing import Parts, publish
from gaitflow.runtime.atlas import Atlas, Sheet

__all__ = ["artifact", "parts", "pristine"]


def perceptron(classes: int, temperature: float = 0.7) -> bytes:
    """Random layers of 2, 30, 20 and `classes` as ONNX, the way the published ones are."""
    random = np.random.default_rng(1)
    nodes, weights, value = [], [], "task"
    sizes = [2, 30, 20, classes]
    for i, (inputs, outputs) in enumerate(pairwise(sizes)):
        numbers = {f"weight_{i}": random.normal(0, 1.5, (outputs, inputs)), f"bias_{i}": random.normal(0, 1, outputs)}
        weights += [numpy_helper.from_array(each.astype(np.float32), name) for name, each in numbers.items()]
        nodes.append(helper.make_node("Gemm", [value, *numbers], [f"sum_{i}"], transB=1))
        value = f"sum_{i}"
        if outputs != classes:
            nodes.append(helper.make_node("Relu", [value], [f"hidden_{i}"]))
            value = f"hidden_{i}"
    weights.append(numpy_helper.from_array(np.array([temperature], dtype=np.float32), "temperature"))
    nodes.append(helper.make_node("Div", [value, "temperature"], ["calibrated"]))
    nodes.append(helper.make_node("Softmax", ["calibrated"], ["probability"], axis=1))
    task = helper.make_tensor_value_info("task", TensorProto.FLOAT, [None, 2])
    probability = helper.make_tensor_value_info("probability", TensorProto.FLOAT, [None, classes])
    graph = helper.make_graph(nodes, "perceptron", [task], [probability], weights)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 15)], ir_version=8)
    return model.SerializeToString(deterministic=True)


def crowded(atlas: Atlas) -> Atlas:
    """Sheets with holes and tears, and two more of the first gait: one cheaper at some tasks, one of few nodes."""
    random = np.random.default_rng(1)
    own = [thinned(sheet, random.random(len(sheet.places)) < 0.8) for sheet in atlas.sheets]
    first = atlas.sheets[0]
    other = replace(first, costs=first.costs * random.uniform(0.8, 1.2, len(first.costs)), mean=first.mean * 0.99)
    few = replace(thinned(first, random.random(len(first.places)) < 0.2), mean=first.mean * 1.01)
    return replace(atlas, sheets=(*own, other, replace(few, costs=few.costs * 0.5)))


def thinned(sheet: Sheet, kept: np.ndarray) -> Sheet:
    own = {"places": sheet.places[kept], "costs": sheet.costs[kept], "coordinates": sheet.coordinates[kept]}
    spread = np.linalg.norm(np.diff(sheet.coordinates[kept], axis=0), axis=1)
    return replace(sheet, **own, tear=float(np.quantile(spread, 0.3)))


@pytest.fixture(scope="session")
def exported(pristine: Path, tmp_path_factory: pytest.TempPathFactory) -> Exported:
    return export_c(pristine, tmp_path_factory.mktemp("exports") / "quickstart-c")


@pytest.fixture(scope="session")
def crowded_export(parts: Parts, tmp_path_factory: pytest.TempPathFactory) -> Exported:
    """The same problem with a perceptron for a classifier and a crowded atlas."""
    made = replace(parts, classifier=perceptron(2), atlas=crowded(parts.atlas))
    model = publish(tmp_path_factory.mktemp("crowded"), made, "1.0.0")
    return export_c(model, tmp_path_factory.mktemp("crowded-exports") / "c")
