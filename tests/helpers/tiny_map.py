"""A small but real map of the half-cheetah: 4 knots a phase, solved gaits, a linear classifier over speed, an atlas."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from onnx import TensorProto, helper, numpy_helper

from gaitflow.atlas.grow import Grown, grow
from gaitflow.atlas.predictors import Judgement, build_atlas
from gaitflow.config.robot import load_robot
from gaitflow.config.scenario import load_scenario
from gaitflow.core.domain import Domain
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.publishing import Parts, publish
from gaitflow.runtime.atlas import Atlas
from gaitflow.search.solution import Solution
from gaitflow.search.starts import nominal
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Start

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


@cache
def tiny_problem() -> GaitProblem:
    scenario = load_scenario(CONFIGS / "scenarios" / "quickstart.yaml")
    scenario = scenario.model_copy(update={"robot": load_robot(ROBOT)})
    transcription = scenario.transcription.model_copy(update={"knots_per_phase": 4})
    return transcribe(scenario.model_copy(update={"transcription": transcription}))


def cold_solve(problem: GaitProblem, pattern: str, speed: float, cycle: float) -> Attempt:
    """IPOPT from the nominal glide."""
    guess = nominal(problem.scenario.robot, problem.layout, speed, cycle)
    return FixedGaitSolver(problem, 20.0).solve(Pattern.from_text(pattern), speed, cycle, Start("nominal", guess))


@cache
def solved_at(gait: str) -> Attempt:
    attempt = cold_solve(tiny_problem(), *SOLVED_AT[gait])
    assert attempt.feasible, attempt.solver_status
    return attempt


def solved_start(gait: str) -> Solved:
    attempt = solved_at(gait)
    return Solved(gait, SOLVED_AT[gait][0], attempt.w, attempt.multipliers.bounds, attempt.multipliers.rows)


def solution_of(pattern: str, speed: float, cycle: float, attempt: Attempt) -> Solution:
    """A solve as the dataset's row."""
    return Solution(
        speed=speed,
        cycle_duration=cycle,
        split="grid",
        pattern=pattern,
        gait=gait_of(Pattern.from_text(pattern)).text,
        strategy="patterns",
        start="nominal",
        seed=0,
        status="solved",
        solver_status=attempt.solver_status,
        cost=attempt.cost,
        violation=attempt.violation,
        iterations=attempt.iterations,
        solves=1,
        wall_s=attempt.wall_s,
        cpu_s=attempt.cpu_s,
        trajectory=attempt.trajectory,
        multipliers=attempt.multipliers,
    )


def tiny_feasible() -> np.ndarray:
    tasks = tiny_problem().scenario.tasks
    feasible = np.ones((tasks.speed.count, tasks.cycle_duration.count), dtype=bool)
    feasible[-1, 0] = False
    return feasible


def tiny_domain() -> Domain:
    tasks = tiny_problem().scenario.tasks
    return Domain(tasks.speed.values, tasks.cycle_duration.values, tuple(map(tuple, tiny_feasible().tolist())))


@cache
def tiny_growth() -> Grown:
    """Both gaits, each spread over the domain from its one solved task."""
    seeds = [solution_of(*SOLVED_AT[gait], solved_at(gait)) for gait in (WALKING, GALLOP)]
    patterns = [Pattern.from_text(seed.pattern) for seed in seeds]
    return grow(tiny_problem(), patterns, seeds, tiny_domain().contains)


@cache
def tiny_atlas() -> tuple[Atlas, tuple[Judgement, ...]]:
    return build_atlas(tiny_growth(), [0, 1])


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
    return Parts(
        problem=tiny_problem(),
        feasible=tiny_feasible(),
        classifier=linear_classifier([-5.0, 5.0], [3.5, -3.5]),
        classifier_kind="perceptron",
        classes=(WALKING, GALLOP),
        starts=[solved_start(WALKING), solved_start(GALLOP)],
        atlas=tiny_atlas()[0],
        dataset={"digest": "0" * 64, "version": "1.0.0"},
        code={"code": {"version": "0.1.0"}, "packages": {"casadi": "3.8.2"}},
        metrics={"accuracy": 0.97, "classes": [WALKING, GALLOP]},
        solver_options={"max_iter": 200, "mumps_pivot_order": 0},
    )


@pytest.fixture(scope="session")
def grown() -> Grown:
    """The nodes that the map's atlas is made of."""
    return tiny_growth()


@pytest.fixture(scope="session")
def judged() -> tuple[Judgement, ...]:
    """How the predictors did that the map's atlas was chosen from."""
    return tiny_atlas()[1]


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
