from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gaitflow import check
from gaitflow.artifact import Parts, publish
from gaitflow.gaits import Pattern
from gaitflow.problem import GaitProblem
from gaitflow.runtime import ArtifactError, GaitMap, Plan
from gaitflow.runtime.plan import refine_ranked
from gaitflow.runtime.refine import Attempt
from gaitflow.solve.guess import nominal
from gaitflow.solve.nlp import FixedGaitSolver, Start
from gaitflow.trajectory import Trajectory

FAST = (2.05, 0.9)  # beyond what walking can do


@pytest.fixture(scope="module")
def gait_map(pristine: Path) -> GaitMap:
    return GaitMap.load(pristine)


@pytest.fixture(scope="module")
def walker(preferring: Callable[[str], Parts], tmp_path_factory: pytest.TempPathFactory) -> GaitMap:
    """A map that ranks walking first everywhere."""
    return GaitMap.load(publish(tmp_path_factory.mktemp("walker"), preferring("walking")))


def _checked(problem: GaitProblem, plan: Plan, speed: float, cycle: float) -> float:
    return check.worst(problem.scenario.as_data(), plan, speed, cycle, plan.pattern)


@pytest.mark.parametrize(("speed", "cycle"), [(0.3, 0.6), (0.55, 1.1), (0.9, 0.6), (1.7, 0.5), FAST])
def test_plans_are_feasible_and_no_dearer_than_a_fresh_solve(
    gait_map: GaitMap, parts: Parts, speed: float, cycle: float
) -> None:
    plan = gait_map.plan(speed=speed, cycle_duration=cycle)
    assert plan.feasible
    assert plan.path == "first"
    assert plan.tried == ((plan.gait, "solved"),)
    assert plan.violation == _checked(parts.problem, plan, speed, cycle) <= 1e-6
    assert plan.durations.sum() == pytest.approx(cycle)
    assert plan.base[-1, 0] - plan.base[0, 0] == pytest.approx(speed * cycle)
    solver = FixedGaitSolver(parts.problem, 20.0)
    guess = nominal(parts.problem.scenario.robot, parts.problem.layout, speed, cycle)
    fresh = solver.solve(Pattern.from_text(plan.pattern), speed, cycle, Start("nominal", guess))
    assert fresh.feasible
    assert 0.95 * fresh.cost < plan.cost <= fresh.cost * (1 + 1e-4)  # the warm start may find a better minimum


def test_the_warm_start_is_used(gait_map: GaitMap, parts: Parts) -> None:
    """At the task that the start was solved for there is next to nothing left to do."""
    plan = gait_map.plan(1.3, 0.6)
    np.testing.assert_allclose(plan.base, parts.problem.layout.unpack(parts.starts[1].primal, 0.6).base, atol=1e-4)
    solver = FixedGaitSolver(parts.problem, 20.0)
    guess = nominal(parts.problem.scenario.robot, parts.problem.layout, 1.3, 0.6)
    cold = solver.solve(Pattern.from_text(plan.pattern), 1.3, 0.6, Start("nominal", guess))
    assert plan.iterations <= 6 < cold.iterations


def test_shapes_of_a_plan(gait_map: GaitMap) -> None:
    plan = gait_map.plan(0.9, 0.6)
    assert plan.times.shape == (17,)
    assert plan.base.shape == (17, 6)
    assert plan.feet.shape == (17, 2, 2)
    assert plan.forces.shape == plan.foot_velocities.shape == (16, 2, 2)
    assert plan.durations.shape == (4,)
    assert plan.time_ms > 0


def test_the_next_gait_is_tried_and_said(walker: GaitMap, parts: Parts) -> None:
    plan = walker.plan(*FAST)
    assert plan.feasible
    assert (plan.gait, plan.path) == ("gallop", "next:1")
    assert plan.probability == walker.select(*FAST).ranked[1][1]
    (first, why), (second, outcome) = plan.tried
    assert (first, second, outcome) == ("walking", "gallop", "solved")
    assert why.startswith("infeasible: violation ")
    assert _checked(parts.problem, plan, *FAST) <= 1e-6


def test_failure_is_said_with_the_least_infeasible_motion(walker: GaitMap, parts: Parts) -> None:
    plan = walker.plan(*FAST, top=1)
    assert not plan.feasible
    assert (plan.gait, plan.path, len(plan.tried)) == ("walking", "failed", 1)
    assert plan.violation == _checked(parts.problem, plan, *FAST) > 1e-3


def test_a_solver_that_stops_early_is_not_believed(artifact: Path, parts: Parts) -> None:
    path = publish(artifact.parents[1] / "hasty", dataclasses.replace(parts, solver_options={"max_iter": 1}))
    plan = GaitMap.load(path).plan(0.55, 1.1)
    assert plan.path == "failed"
    assert [gait for gait, _ in plan.tried] == ["walking", "gallop"]
    assert all("Maximum_Iterations_Exceeded" in outcome for _, outcome in plan.tried)


def test_a_solver_that_throws_costs_one_gait(artifact: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gait_map = GaitMap.load(artifact)
    refiner = gait_map._load_refiner()
    real, calls = refiner._solver, []

    class Throwing:
        def __call__(self, **arguments: object) -> object:
            calls.append(1)
            if len(calls) == 1:
                raise RuntimeError("Error in Function::call\nsingular")
            return real(**arguments)

        def stats(self) -> dict:
            return real.stats()

    monkeypatch.setattr(refiner, "_solver", Throwing())
    plan = gait_map.plan(0.9, 0.6)
    assert plan.feasible
    assert (plan.gait, plan.path) == ("walking", "next:1")
    assert "the solver failed: singular" in plan.tried[0][1]


class Scripted:
    """A refiner whose solves end as told: (violation, solver status) by gait."""

    def __init__(self, gait_map: GaitMap, *ends: tuple[float, str]) -> None:
        self._trajectory = gait_map.select(0.9, 0.6).warm_start
        self._ends = ends

    def solve(self, gait: int, speed: float, cycle_duration: float) -> Attempt:
        fields = {field.name: getattr(self._trajectory, field.name) for field in dataclasses.fields(Trajectory)}
        violation, status = self._ends[gait]
        return Attempt(Trajectory(**fields), 10.0 + gait, violation, 7, status)


GOOD, LIMIT = "Solve_Succeeded", "Maximum_Iterations_Exceeded"


@pytest.mark.parametrize(
    ("ends", "gait", "path", "feasible", "outcomes"),
    [
        ([(0.0, GOOD), (0.0, GOOD)], "walking", "first", True, ["solved"]),
        # The solver's success is not believed when the check disagrees.
        ([(1e-3, GOOD), (0.0, GOOD)], "gallop", "next:1", True, ["infeasible: violation 1.0e-03", "solved"]),
        # Feasible but no minimum: another gait is tried, and the motion kept when none is better.
        ([(0.0, LIMIT), (0.0, GOOD)], "gallop", "next:1", True, ["not converged", "solved"]),
        ([(1e-9, LIMIT), (1e-2, LIMIT)], "walking", "failed", True, ["not converged", "infeasible"]),
        ([(np.inf, LIMIT), (1e-2, GOOD)], "gallop", "failed", False, ["infeasible: violation inf", "infeasible"]),
    ],
)
def test_both_the_check_and_the_solver_must_agree(
    gait_map: GaitMap, ends: list, gait: str, path: str, feasible: bool, outcomes: list[str]
) -> None:
    ranked = [(index, each, 0.5 - 0.1 * index) for index, each in enumerate(gait_map.gaits)]
    plan = refine_ranked(Scripted(gait_map, *ends), ranked, 0.9, 0.6, started=0.0)
    assert (plan.gait, plan.path, plan.feasible) == (gait, path, feasible)
    assert [name for name, _ in plan.tried] == ["walking", "gallop"][: len(outcomes)]
    assert all(said.startswith(outcome) for (_, said), outcome in zip(plan.tried, outcomes, strict=True))
    assert plan.iterations == 7 * len(outcomes)
    assert plan.cost == (10.0 if gait == "walking" else 11.0)
    assert plan.probability == (0.5 if gait == "walking" else 0.4)


@pytest.mark.parametrize("top", [0, -1, 1.5, "2", None, True])
def test_bad_top_is_refused(gait_map: GaitMap, top: object) -> None:
    with pytest.raises(ValueError, match="top = "):
        gait_map.plan(0.9, 0.6, top=top)


def test_plans_from_threads_do_not_disturb_each_other(artifact: Path) -> None:
    gait_map = GaitMap.load(artifact)
    tasks = [(0.3, 0.6), (0.9, 0.6), (1.3, 0.8), (1.7, 0.6)]
    plans: dict[tuple[float, float], Plan] = {}
    threads = [
        threading.Thread(target=lambda task=task: plans.__setitem__(task, gait_map.plan(*task))) for task in tasks
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for task in tasks:
        alone = gait_map.plan(*task)
        assert plans[task].feasible
        assert plans[task].cost == pytest.approx(alone.cost, rel=1e-9)


@pytest.mark.parametrize("content", [b"", b"garbage", b"\xff\xfe\x00"])
def test_a_problem_that_is_no_function_is_refused(artifact: Path, content: bytes) -> None:
    (artifact / "problem.casadi").write_bytes(content)
    with pytest.raises(ArtifactError, match=r"problem\.casadi"):
        GaitMap.load(artifact).plan(0.9, 0.6)
