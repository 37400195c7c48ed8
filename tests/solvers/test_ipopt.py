from __future__ import annotations

import math
from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from gaitflow.config.scenario import Scenario, Transcription
from gaitflow.core.check import worst
from gaitflow.core.gaits import Pattern
from gaitflow.core.task import Task
from gaitflow.problem import Bounds, GaitProblem, transcribe
from gaitflow.search import starts as guess
from gaitflow.search.attempts import solution
from gaitflow.solvers import ipopt
from gaitflow.solvers.ipopt import IPOPT, Attempt, FixedGaitSolver, Start, call_solver, make_ipopt

Solve = Callable[..., Attempt]

# (pattern, v, T): iterations from the nominal start, and at v + 0.1 from that solution, primal and dual.
GOLDEN = [
    ("0110/1100", 0.9, 0.6, 27, 16, 7103.3864),
    ("0111/1101", 0.2, 0.8, 24, 8, 8383.2337),
    ("0001/0100", 1.9, 1.4, 21, 11, 45930.854),
]


@pytest.fixture(scope="module")
def solver(effort: Scenario) -> FixedGaitSolver:
    return FixedGaitSolver(transcribe(effort), 20.0)


def _nominal(solver: FixedGaitSolver, speed: float, cycle: float) -> Start:
    problem = solver.problem
    return Start("nominal", guess.nominal(problem.scenario.robot, problem.layout, speed, cycle))


@pytest.mark.parametrize(("text", "speed", "cycle", "cold", "warm", "cost"), GOLDEN)
def test_iterations_cold_and_warm(
    solver: FixedGaitSolver, text: str, speed: float, cycle: float, cold: int, warm: int, cost: float
) -> None:
    """Iterations, not seconds: a change of the program or of the options that costs speed shows here."""
    pattern = Pattern.from_text(text)
    first = solver.solve(pattern, speed, cycle, _nominal(solver, speed, cycle))
    assert first.feasible
    assert first.cost == pytest.approx(cost, rel=1e-6)
    assert abs(first.iterations - cold) <= 2
    second = solver.solve(pattern, speed + 0.1, cycle, Start("neighbour", first.w, first.multipliers))
    assert second.feasible
    assert abs(second.iterations - warm) <= 2
    again = solver.solve(pattern, speed + 0.1, cycle, _nominal(solver, speed + 0.1, cycle))
    assert second.cost == pytest.approx(again.cost, rel=1e-5)


def test_an_attempt_tells_what_was_found(solver: FixedGaitSolver, effort: Scenario) -> None:
    pattern = Pattern.from_text("0110/1100")
    attempt = solver.solve(pattern, 0.9, 0.6, _nominal(solver, 0.9, 0.6))
    layout = solver.problem.layout
    assert attempt.start == "nominal"
    assert attempt.solver_status == "Solve_Succeeded"
    assert not attempt.gave_up
    assert attempt.violation == worst(effort.as_data(), attempt.trajectory, 0.9, 0.6, pattern.text)
    np.testing.assert_allclose(layout.pack(attempt.trajectory, 0.6), attempt.w, rtol=1e-12)
    h = np.diff(attempt.trajectory.times)
    assert attempt.cost == pytest.approx(h @ (attempt.trajectory.forces**2).sum(axis=(1, 2)))
    assert attempt.multipliers.bounds.shape == (layout.nw,)
    assert attempt.multipliers.rows.shape == (solver.problem.ng,)
    assert attempt.cpu_s > 0 and attempt.wall_s > 0


@pytest.mark.parametrize(
    ("text", "speed", "cycle"),
    [
        ("1111/1111", 0.5, 0.6),  # a foot that never lifts does not advance
        ("0000/0000", 0.5, 0.6),  # nobody flies for ever
        ("0110/1100", 8.5, 0.6),  # feet go at most 8 m/s
        ("0111/1101", 6.0, 1.0),  # stance travel beyond the box
    ],
)
def test_what_cannot_be_walked_is_never_solved(
    solver: FixedGaitSolver, effort: Scenario, text: str, speed: float, cycle: float
) -> None:
    robot, layout = effort.robot, solver.problem.layout
    pattern = Pattern.from_text(text)
    starts = [_nominal(solver, speed, cycle)]
    starts += [Start("r", guess.random(robot, layout, speed, cycle, np.random.default_rng(k))) for k in range(2)]
    attempts = [solver.solve(pattern, speed, cycle, start) for start in starts]
    assert not any(attempt.feasible for attempt in attempts)
    assert min(attempt.violation for attempt in attempts) > 1e-3
    row = solution(effort, Task(speed, cycle), pattern, attempts)
    assert row.status in ("infeasible", "failed")
    assert math.isnan(row.cost)
    assert row.trajectory is None


def test_a_time_limit_gives_up(effort: Scenario) -> None:
    hurried = FixedGaitSolver(transcribe(effort), 1e-4)
    attempt = hurried.solve(Pattern.from_text("0110/1100"), 0.9, 0.6, _nominal(hurried, 0.9, 0.6))
    assert attempt.gave_up
    assert not attempt.feasible
    assert "Time" in attempt.solver_status
    assert solution(effort, Task(0.9, 0.6), Pattern.from_text("0110/1100"), [attempt]).status == "failed"


def test_an_exception_of_the_solver_is_a_failed_attempt(effort: Scenario, monkeypatch: pytest.MonkeyPatch) -> None:
    """CasADi throws on bounds that contradict; the start comes back, judged like any other point."""
    honest = GaitProblem.bounds

    def swapped(self: GaitProblem, pattern: Pattern) -> Bounds:
        bounds = honest(self, pattern)
        return Bounds(bounds.upper, bounds.lower, bounds.lower_rows, bounds.upper_rows)

    monkeypatch.setattr(GaitProblem, "bounds", swapped)
    solver = FixedGaitSolver(transcribe(effort), 20.0)
    start = _nominal(solver, 0.9, 0.6)
    attempt = solver.solve(Pattern.from_text("0110/1100"), 0.9, 0.6, start)
    assert attempt.solver_status.startswith("exception: ")
    assert not attempt.feasible
    assert attempt.gave_up
    assert math.isnan(attempt.cost)
    assert attempt.iterations == 0
    np.testing.assert_array_equal(attempt.w, start.w)


@pytest.mark.parametrize("claim", ["Solve_Succeeded", "Solved_To_Acceptable_Level", "Maximum_Iterations_Exceeded"])
def test_a_solver_that_lies_is_not_believed(
    solver: FixedGaitSolver, effort: Scenario, monkeypatch: pytest.MonkeyPatch, claim: str
) -> None:
    """Success at an infeasible point proves nothing: neither that the gait can be walked nor that it cannot."""

    def lie(program: ca.Function, arguments: dict) -> tuple:
        blank = np.zeros(solver.problem.ng)
        return claim, 7, {"x": arguments["x0"], "f": np.zeros(1), "lam_x": 0 * arguments["x0"], "lam_g": blank}

    monkeypatch.setattr(ipopt, "call_solver", lie)
    attempt = solver.solve(Pattern.from_text("0110/1100"), 0.9, 0.6, _nominal(solver, 0.9, 0.6))
    assert attempt.violation > 1e-3
    assert not attempt.feasible
    assert attempt.gave_up
    assert solution(effort, Task(0.9, 0.6), Pattern.from_text("0110/1100"), [attempt]).status == "failed"


def test_a_feasible_point_short_of_the_minimum_is_not_solved(
    solver: FixedGaitSolver, monkeypatch: pytest.MonkeyPatch
) -> None:
    pattern = Pattern.from_text("0110/1100")
    true = solver.solve(pattern, 0.9, 0.6, _nominal(solver, 0.9, 0.6))

    def stopped(program: ca.Function, arguments: dict) -> tuple:
        blank = np.zeros(solver.problem.ng)
        return "Maximum_CpuTime_Exceeded", 7, {"x": true.w, "f": np.ones(1), "lam_x": 0 * true.w, "lam_g": blank}

    monkeypatch.setattr(ipopt, "call_solver", stopped)
    attempt = solver.solve(pattern, 0.9, 0.6, _nominal(solver, 0.9, 0.6))
    assert attempt.violation <= 1e-6
    assert not attempt.feasible


def test_a_start_that_is_not_a_number_fails(solver: FixedGaitSolver) -> None:
    start = Start("broken", np.full(solver.problem.layout.nw, math.nan))
    attempt = solver.solve(Pattern.from_text("0110/1100"), 0.9, 0.6, start)
    assert not attempt.feasible
    assert attempt.gave_up


@pytest.mark.parametrize(("text", "speed", "cycle"), [("0110/1100", 0.9, 0.6), ("0111/1101", 0.2, 0.8)])
def test_the_big_m_form_with_fixed_contacts_has_the_same_optimum(
    effort: Scenario, solve: Solve, text: str, speed: float, cycle: float
) -> None:
    """The paper's fixed-gait problem and ours differ in how a solver sees them, not in what they say."""
    scenario = effort.model_copy(update={"transcription": Transcription(knots_per_phase=5)})
    problem = transcribe(scenario)
    pattern = Pattern.from_text(text)
    bounds = problem.minlp_bounds(pattern)
    contacts = [float(digit) for row in pattern.rows for digit in row]
    start = np.append(guess.nominal(scenario.robot, problem.layout, speed, cycle), contacts)
    patient = IPOPT | {"max_iter": 1000}  # this form takes several times as many iterations
    status, _, result = call_solver(make_ipopt(problem.minlp, patient), {
        "x0": start, "p": [speed, cycle], "lbx": bounds.lower, "ubx": bounds.upper,
        "lbg": bounds.lower_rows, "ubg": bounds.upper_rows,
    })  # fmt: skip
    assert status == "Solve_Succeeded"
    ours = solve(scenario, text, speed, cycle)
    assert float(result["f"][0]) * problem.cost_scale == pytest.approx(ours.cost, rel=1e-5)


def test_phases_that_just_fill_the_cycle_can_be_solved(effort: Scenario, solve: Solve) -> None:
    """Five phases of at least 0.2 T leave the durations no freedom at all."""
    transcription = Transcription(phases=5, knots_per_phase=4, min_phase_fraction=0.2)
    attempt = solve(effort.model_copy(update={"transcription": transcription}), "01100/11000", 0.5, 0.6)
    assert attempt.feasible
    np.testing.assert_allclose(attempt.trajectory.durations, 0.12, rtol=1e-6)
