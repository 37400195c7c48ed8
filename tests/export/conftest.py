"""The small real map, exported: as it is; with a perceptron and a fuller atlas; over slopes; over four axes."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from onnx import TensorProto, helper, numpy_helper
from tiny_map import TinyMap, artifact, pristine, scenario_of, solved_start, tiny, write_map

from gaitflow.config.scenario import Range, Scenario
from gaitflow.core.domain import Domain
from gaitflow.core.gaits import Pattern
from gaitflow.export import Exported, export_c
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.runtime.atlas import Atlas, Sheet
from gaitflow.solvers.point import GaitSpace

__all__ = ["artifact", "pristine", "tiny"]


def perceptron(classes: int, axes: int = 2, temperature: float = 0.7) -> bytes:
    """Random layers of `axes`, 30, 20 and `classes` as ONNX, the way the published ones are."""
    random = np.random.default_rng(1)
    nodes, weights, value = [], [], "task"
    sizes = [axes, 30, 20, classes]
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
    task = helper.make_tensor_value_info("task", TensorProto.FLOAT, [None, axes])
    probability = helper.make_tensor_value_info("probability", TensorProto.FLOAT, [None, classes])
    graph = helper.make_graph(nodes, "perceptron", [task], [probability], weights)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 15)], ir_version=8)
    return model.SerializeToString(deterministic=True)


def crowded(atlas: Atlas) -> Atlas:
    """Sheets with holes and tears, and two more of the first gait: one cheaper at some tasks, one of few nodes."""
    random = np.random.default_rng(1)
    own = [thinned(sheet, random.random(len(sheet.tasks)) < 0.8) for sheet in atlas.sheets]
    first = atlas.sheets[0]
    other = replace(first, costs=first.costs * random.uniform(0.8, 1.2, len(first.costs)), mean=first.mean * 0.99)
    few = replace(thinned(first, random.random(len(first.tasks)) < 0.3), mean=first.mean * 1.01)
    own[0] = replace(own[0], infeasible=random.uniform(first.tasks.min(axis=0), first.tasks.max(axis=0), (9, 2)))
    return replace(atlas, sheets=(*own, other, replace(few, costs=few.costs * 0.5)))


def thinned(sheet: Sheet, kept: np.ndarray) -> Sheet:
    names = ("tasks", "costs", "slopes", "coordinates", "tangents")
    spread = np.linalg.norm(np.diff(sheet.coordinates[kept], axis=0), axis=1)
    return replace(sheet, **{name: getattr(sheet, name)[kept] for name in names}, tear=float(np.median(spread)))


def sloped_scenario(**axes: Range) -> Scenario:
    """Speed, cycle duration, slope and further axes; linear forces on graded knots."""
    data = scenario_of(slope=Range(start=-10.0, stop=10.0, count=3), **axes).as_data()
    data["transcription"] |= {"integrator": "momentum", "forces": "linear", "grading": 0.7, "knots_per_phase": 3}
    return Scenario.from_data(data, "sloped")


def scattered_sheet(problem: GaitProblem, pattern: str, gait: int) -> Sheet:
    """Random nodes over the box of the tasks, random modes and tangents: what the atlas predicts need not be good."""
    random, modes, nodes = np.random.default_rng(gait), 5, 60
    ranges = problem.scenario.tasks.ranges.values()
    tasks = random.uniform([r.start for r in ranges], [r.stop for r in ranges], (nodes, len(ranges)))
    bounds = problem.bounds(Pattern.from_text(pattern))
    space = GaitSpace(bounds.lower, bounds.upper, bounds.lower_rows, bounds.upper_rows)
    return Sheet(
        gait=gait,
        pattern=pattern,
        space=space,
        tasks=tasks,
        costs=random.uniform(1.0, 1.2, nodes),
        slopes=random.normal(0, 0.1, (nodes, len(ranges))),
        mean=random.normal(size=space.size).astype(np.float32),
        modes=random.normal(size=(modes, space.size)).astype(np.float32),
        coordinates=random.normal(size=(nodes, modes)).astype(np.float32),
        tangents=random.normal(0, 0.1, (nodes, len(ranges), modes)).astype(np.float32),
        tear=3.0,
        infeasible=random.uniform([r.start for r in ranges], [r.stop for r in ranges], (nodes // 4, len(ranges))),
    )


def scattered_map(tiny: TinyMap, scenario: Scenario) -> TinyMap:
    """A map over a scenario's axes; its vectors are random, so that everything has to be put in its right place."""
    problem = transcribe(scenario)
    ranges, random = problem.scenario.tasks.ranges, np.random.default_rng(3)
    feasible = random.random([each.count for each in ranges.values()]) < 0.95
    starts = [
        replace(
            solved_start(start.gait),
            primal=random.normal(size=problem.layout.nw),
            bounds=random.normal(size=problem.layout.nw),
            rows=random.normal(size=problem.ng),
        )
        for start in tiny.starts
    ]
    sheets = [scattered_sheet(problem, start.pattern, gait) for gait, start in enumerate(starts)]
    steps = np.array([(each.stop - each.start) / (each.count - 1) for each in ranges.values()])
    return replace(
        tiny,
        problem=problem,
        domain=Domain({axis: each.values for axis, each in ranges.items()}, feasible),
        classifier=perceptron(2, len(ranges)),
        starts=tuple(starts),
        atlas=Atlas(tuple(ranges), steps * [1.0, *[0.5] * (len(ranges) - 1)], 1e-4, tuple(sheets)),
    )


@pytest.fixture(scope="session")
def exported(pristine: Path, tmp_path_factory: pytest.TempPathFactory) -> Exported:
    return export_c(pristine, tmp_path_factory.mktemp("exports") / "quickstart-c")


@pytest.fixture(scope="session")
def crowded_export(tiny: TinyMap, tmp_path_factory: pytest.TempPathFactory) -> Exported:
    """The same problem with a perceptron for a classifier and a crowded atlas."""
    made = replace(tiny, classifier=perceptron(2), atlas=crowded(tiny.atlas))
    model = write_map(made, tmp_path_factory.mktemp("crowded") / "quickstart")
    return export_c(model, tmp_path_factory.mktemp("crowded-exports") / "c")


@pytest.fixture(scope="session")
def sloped_export(tiny: TinyMap, tmp_path_factory: pytest.TempPathFactory) -> Exported:
    """A map of three axes with linear forces."""
    made = scattered_map(tiny, sloped_scenario())
    model = write_map(made, tmp_path_factory.mktemp("sloped") / "quickstart")
    return export_c(model, tmp_path_factory.mktemp("sloped-exports") / "c")


@pytest.fixture(scope="session")
def wide_export(tiny: TinyMap, tmp_path_factory: pytest.TempPathFactory) -> Exported:
    """A map of four axes, whose plans take the nominal start."""
    made = scattered_map(tiny, sloped_scenario(payload=Range(start=0.0, stop=5.0, count=2)))
    unsure = replace(made, classifier=perceptron(2, 4, temperature=40.0))  # likely and unlikely gaits, and all between
    model = write_map(unsure, tmp_path_factory.mktemp("wide") / "quickstart")
    return export_c(model, tmp_path_factory.mktemp("wide-exports") / "c")
