"""A small but real map of the half-cheetah: 4 knots a phase, solved gaits, a linear classifier over speed."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from onnx import TensorProto, helper, numpy_helper

from gaitflow.artifact import Parts, publish
from gaitflow.gaits import Pattern
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.robots import load_robot
from gaitflow.scenario import load_scenario
from gaitflow.solve.guess import nominal
from gaitflow.solve.nlp import FixedGaitSolver, Start

CONFIGS = Path(__file__).parents[2] / "configs"
ROBOT = Path(__file__).parents[1] / "data" / "robots" / "planar.yaml"  # stays as it is when the shipped one changes
WALKING, GALLOP = "walking", "gallop"
# The task that each gait's start is solved for.
SOLVED_AT = {WALKING: ("0111/1101", 0.3, 0.6), GALLOP: ("0110/1100", 1.3, 0.6)}


@dataclass(frozen=True)
class Solved:
    """A solved gait as a region's start."""

    gait: str
    pattern: str
    primal: np.ndarray
    bounds: np.ndarray
    rows: np.ndarray


def tiny_problem() -> GaitProblem:
    scenario = load_scenario(CONFIGS / "scenarios" / "quickstart.yaml")
    scenario = scenario.model_copy(update={"robot": load_robot(ROBOT)})
    transcription = scenario.transcription.model_copy(update={"knots_per_phase": 4})
    return transcribe(scenario.model_copy(update={"transcription": transcription}))


def solved_start(problem: GaitProblem, gait: str) -> Solved:
    pattern, speed, cycle = SOLVED_AT[gait]
    solver = FixedGaitSolver(problem, time_limit=20.0)
    guess = nominal(problem.scenario.robot, problem.layout, speed, cycle)
    attempt = solver.solve(Pattern.from_text(pattern), speed, cycle, Start("nominal", guess))
    assert attempt.feasible, attempt.solver_status
    return Solved(gait, pattern, attempt.w, attempt.multipliers.bounds, attempt.multipliers.rows)


def linear_classifier(slopes: Sequence[float], offsets: Sequence[float]) -> bytes:
    """softmax(slopes * speed + offsets) as ONNX."""
    weights = np.array([slopes, np.zeros(len(slopes))], dtype=np.float32)
    graph = helper.make_graph(
        [
            helper.make_node("Gemm", ["task", "weights", "offsets"], ["scores"]),
            helper.make_node("Softmax", ["scores"], ["probability"], axis=1),
        ],
        "tiny",
        [helper.make_tensor_value_info("task", TensorProto.FLOAT, [None, 2])],
        [helper.make_tensor_value_info("probability", TensorProto.FLOAT, [None, len(slopes)])],
        [
            numpy_helper.from_array(weights, "weights"),
            numpy_helper.from_array(np.array(offsets, dtype=np.float32), "offsets"),
        ],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 15)], ir_version=8)
    return model.SerializeToString(deterministic=True)


@pytest.fixture(scope="session")
def parts() -> Parts:
    """Walking below 0.7 m/s, gallop above; the fastest shortest task of the grid has no feasible gait."""
    problem = tiny_problem()
    tasks = problem.scenario.tasks
    feasible = np.ones((tasks.speed.count, tasks.cycle_duration.count), dtype=bool)
    feasible[-1, 0] = False
    return Parts(
        problem=problem,
        feasible=feasible,
        classifier=linear_classifier([-5.0, 5.0], [3.5, -3.5]),
        classifier_kind="perceptron",
        classes=(WALKING, GALLOP),
        starts=[solved_start(problem, WALKING), solved_start(problem, GALLOP)],
        dataset={"digest": "0" * 64, "version": "1.0.0"},
        code={"code": {"version": "0.1.0"}, "packages": {"casadi": "3.8.2"}},
        metrics={"accuracy": 0.97, "classes": [WALKING, GALLOP]},
        solver_options={"max_iter": 200, "mumps_pivot_order": 0},
    )


@pytest.fixture(scope="session")
def preferring(parts: Parts) -> Callable[[str], Parts]:
    """The same map with a classifier that picks the named gait everywhere."""

    def made(gait: str) -> Parts:
        return replace(
            parts, classifier=linear_classifier([0.0, 0.0], [4.0 * (name == gait) for name in parts.classes])
        )

    return made


@pytest.fixture(scope="session")
def pristine(parts: Parts, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A published version that no test may change."""
    return publish(tmp_path_factory.mktemp("models"), parts, "1.0.0")


@pytest.fixture
def artifact(pristine: Path, tmp_path: Path) -> Path:
    """A published version of one's own: <tmp_path>/quickstart/1.0.0."""
    return Path(shutil.copytree(pristine, tmp_path / "quickstart" / "1.0.0"))
