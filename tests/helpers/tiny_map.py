"""A small but real map of the half-cheetah: 4 knots a phase, solved gaits, a linear classifier over speed, an atlas.

`tiny_map` is written by the runtime's own writers, so that the tests of the runtime need no publisher; `parts` are the
same map for the publisher.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from onnx import TensorProto, helper, numpy_helper

from gaitflow.atlas.compress import build_atlas
from gaitflow.atlas.grow import Growth, grow
from gaitflow.config.robot import load_robot
from gaitflow.config.scenario import Range, Scenario, digest_of, load_scenario
from gaitflow.core.domain import Domain
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.task import Task
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.atlas_file import atlas_bytes
from gaitflow.runtime.files import ATLAS, CARD, CLASSIFIER, MANIFEST, PROBLEM_CHECK, WARM_STARTS, entry_of
from gaitflow.runtime.manifest import FORMAT, encode
from gaitflow.runtime.problem_check import problem_check_bytes, record
from gaitflow.runtime.tensors import GaitTensors, tensor_bytes
from gaitflow.search.rows import solution
from gaitflow.search.solution import Solution
from gaitflow.search.starts import nominal
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Start

if TYPE_CHECKING:
    from gaitflow.publishing import Parts

CONFIGS = Path(__file__).parents[2] / "configs"
ROBOT = Path(__file__).parents[1] / "data" / "robots" / "planar.yaml"  # stays as it is when the shipped one changes
WALKING, GALLOP = "walking", "gallop"
# The task of the grid that each gait's start is solved for.
SOLVED_AT = {WALKING: ("0111/1101", 0.5, 0.666666667), GALLOP: ("0110/1100", 1.3, 0.666666667)}


@dataclass(frozen=True)
class Solved:
    """A solved gait as a region's start."""

    gait: str
    pattern: str
    primal: np.ndarray
    bounds: np.ndarray
    rows: np.ndarray


@dataclass(frozen=True)
class TinyMap:
    """What a map's files are written from."""

    problem: GaitProblem
    domain: Domain
    classifier: bytes
    classes: tuple[str, ...]
    starts: tuple[Solved, ...]
    atlas: Atlas
    solver_options: dict[str, float | int | str]


def scenario_of(**axes: Range | float) -> Scenario:
    """The quickstart's scenario with 4 knots a phase, the tests' own robot, and other axes where given."""
    scenario = load_scenario(CONFIGS / "scenarios" / "quickstart.yaml")
    transcription = scenario.transcription.model_copy(update={"knots_per_phase": 4})
    data = scenario.model_copy(update={"robot": load_robot(ROBOT), "transcription": transcription}).as_data()
    ranges = {axis: each.as_data() if isinstance(each, Range) else each for axis, each in axes.items()}
    data["tasks"]["axes"] = data["tasks"]["axes"] | ranges
    return Scenario.from_data(data, "tiny map")


@cache
def tiny_problem() -> GaitProblem:
    return transcribe(scenario_of())


def task_of(speed: float, cycle: float, **axes: float) -> Task:
    return Task.of({"speed": speed, "cycle_duration": cycle, "friction": 0.8} | axes)


@cache
def _solver(problem_digest: str) -> FixedGaitSolver:
    return FixedGaitSolver(_problems[problem_digest], 20.0)


_problems: dict[str, GaitProblem] = {}


def cold_solve(problem: GaitProblem, pattern: str, speed: float, cycle: float, **axes: float) -> Attempt:
    """From the nominal glide."""
    digest = problem.scenario.problem_digest
    _problems.setdefault(digest, problem)
    task = task_of(speed, cycle, **axes)
    guess = nominal(problem.scenario.robot, problem.layout, task)
    return _solver(digest).solve(Pattern.from_text(pattern), task, Start("nominal", guess))


@cache
def solved_at(gait: str) -> Attempt:
    attempt = cold_solve(tiny_problem(), *SOLVED_AT[gait])
    assert attempt.feasible, attempt.solver_status
    return attempt


def solved_start(gait: str) -> Solved:
    attempt = solved_at(gait)
    return Solved(gait, SOLVED_AT[gait][0], attempt.w, attempt.multipliers.bounds, attempt.multipliers.rows)


def solution_of(pattern: str, task: Task, attempt: Attempt) -> Solution:
    """A solve as the dataset's row."""
    return solution(tiny_problem().scenario, task, Pattern.from_text(pattern), [attempt])


def tiny_domain() -> Domain:
    """The grid; the fastest shortest task has no feasible gait."""
    axes = {axis: values.values for axis, values in tiny_problem().scenario.tasks.ranges.items()}
    feasible = np.ones(tuple(map(len, axes.values())), dtype=bool)
    feasible[-1, 0] = False
    return Domain(axes, feasible)


@cache
def tiny_growth() -> Growth:
    """Both gaits, each spread over the domain from its one solved task."""
    seeds = [
        solution_of(pattern, task_of(speed, cycle), solved_at(gait))
        for gait, (pattern, speed, cycle) in SOLVED_AT.items()
    ]
    return grow(tiny_problem(), [Pattern.from_text(seed.pattern) for seed in seeds], seeds, tiny_domain())


@cache
def tiny_atlas() -> Atlas:
    return build_atlas(tiny_growth(), [0, 1])


def linear_classifier(slopes: Sequence[float], offsets: Sequence[float], axes: int = 2) -> bytes:
    """softmax(slopes * (value on the first axis) + offsets) as ONNX."""
    weights = np.array([slopes, *[np.zeros(len(slopes))] * (axes - 1)], dtype=np.float32)
    graph = helper.make_graph(
        [
            helper.make_node("Gemm", ["task", "weights", "offsets"], ["scores"]),
            helper.make_node("Softmax", ["scores"], ["probability"], axis=1),
        ],
        "tiny",
        [helper.make_tensor_value_info("task", TensorProto.FLOAT, [None, axes])],
        [helper.make_tensor_value_info("probability", TensorProto.FLOAT, [None, len(slopes)])],
        [
            numpy_helper.from_array(weights, "weights"),
            numpy_helper.from_array(np.array(offsets, dtype=np.float32), "offsets"),
        ],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 15)], ir_version=8)
    return model.SerializeToString(deterministic=True)


def tensors_of(problem: GaitProblem, starts: Sequence[Solved]) -> GaitTensors:
    bounds = [problem.bounds(Pattern.from_text(start.pattern)) for start in starts]
    return GaitTensors(
        primal=np.array([start.primal for start in starts]),
        multipliers_bounds=np.array([start.bounds for start in starts]),
        multipliers_rows=np.array([start.rows for start in starts]),
        lower_bounds=np.array([each.lower for each in bounds]),
        upper_bounds=np.array([each.upper for each in bounds]),
        lower_rows=np.array([each.lower_rows for each in bounds]),
        upper_rows=np.array([each.upper_rows for each in bounds]),
    )


def write_map(tiny: TinyMap, folder: Path, version: str = "1.0.0") -> Path:
    """The artifact `folder/<version>`."""
    target = folder / version
    target.mkdir(parents=True)
    scenario = tiny.problem.scenario.as_data()
    rng, problem = np.random.default_rng(0), tiny.problem
    task = problem.scenario.tasks.space.task({axis: values[0] for axis, values in tiny.domain.axes.items()})
    points = [start.primal for start in tiny.starts[:1]] + [rng.normal(size=problem.layout.nw) for _ in range(2)]
    files = {
        CARD: b"# A map for tests\n",
        CLASSIFIER: tiny.classifier,
        WARM_STARTS: tensor_bytes(tensors_of(problem, tiny.starts)),
        ATLAS: atlas_bytes(tiny.atlas),
        PROBLEM_CHECK: problem_check_bytes(record(problem.nlp, points, [task] * 3)),
    }
    manifest = {
        "format": FORMAT,
        "version": version,
        "created": "2026-01-31T12:00:00Z",
        "scenario": scenario,
        "scenario_digest": digest_of(scenario),
        "dataset": {"name": scenario["name"], "version": "1.0.0"},
        "code": {"code": {"version": "0.0.9"}},
        "domain": {
            "axes": {axis: list(values) for axis, values in tiny.domain.axes.items()},
            "feasible": tiny.domain.feasible.tolist(),
        },
        "gaits": [
            {"name": start.gait, "key": gait_of(Pattern.from_text(start.pattern)).text, "pattern": start.pattern}
            for start in tiny.starts
        ],
        "cost_scale": problem.cost_scale,
        "classifier": {"kind": "perceptron"},
        "metrics": {"accuracy": 0.97},
        "solver": {"options": tiny.solver_options},
        "files": {name: asdict(entry_of(content)) for name, content in files.items()},
    }
    for name, content in (files | {MANIFEST: encode(manifest)}).items():
        (target / name).write_bytes(content)
    return target


@pytest.fixture(scope="session")
def tiny() -> TinyMap:
    """The classifier says walking below 0.7 m/s, gallop above."""
    return TinyMap(
        problem=tiny_problem(),
        domain=tiny_domain(),
        classifier=linear_classifier([-5.0, 5.0], [3.5, -3.5]),
        classes=(WALKING, GALLOP),
        starts=(solved_start(WALKING), solved_start(GALLOP)),
        atlas=tiny_atlas(),
        solver_options={"max_iter": 200, "mumps_pivot_order": 0},
    )


@pytest.fixture(scope="session")
def preferring(tiny: TinyMap) -> Callable[[str], TinyMap]:
    """The same map with a classifier that picks the named gait everywhere."""

    def made(gait: str) -> TinyMap:
        return replace(tiny, classifier=linear_classifier([0.0, 0.0], [4.0 * (name == gait) for name in tiny.classes]))

    return made


@pytest.fixture(scope="session")
def parts(tiny: TinyMap) -> Parts:
    """The same map for the publisher."""
    from gaitflow.publishing import Parts

    return Parts(
        problem=tiny.problem,
        feasible=tiny.domain.feasible,
        classifier=tiny.classifier,
        classifier_kind="perceptron",
        classes=tiny.classes,
        starts=list(tiny.starts),
        atlas=tiny.atlas,
        dataset={"name": "quickstart", "version": "1.0.0"},
        code={"code": {"version": "0.1.0"}, "packages": {"casadi": "3.8.2"}},
        metrics={"accuracy": 0.97, "classes": [WALKING, GALLOP]},
        solver_options=tiny.solver_options,
    )


@pytest.fixture(scope="session")
def grown() -> Growth:
    """The nodes that the map's atlas is made of."""
    return tiny_growth()


@pytest.fixture(scope="session")
def pristine(tiny: TinyMap, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A published version that no test may change."""
    return write_map(tiny, tmp_path_factory.mktemp("models") / "quickstart")


@pytest.fixture
def artifact(pristine: Path, tmp_path: Path) -> Path:
    """A published version of one's own: <tmp_path>/quickstart/1.0.0."""
    return Path(shutil.copytree(pristine, tmp_path / "quickstart" / "1.0.0"))
