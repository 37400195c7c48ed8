from __future__ import annotations

import math
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from tasks_at import at
from to_solve import Solve, nominal

from gaitflow.config.scenario import Scenario, Transcription, load_scenario
from gaitflow.core.check import FEASIBLE, worst
from gaitflow.core.gaits import Pattern, all_patterns
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.search import starts
from gaitflow.solvers import fixed_gait
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Start
from gaitflow.solvers.interior_point import InteriorPoint, Outcome
from gaitflow.solvers.program import Program

GALLOP, TASK = Pattern.from_text("0110/1100"), at(0.9, 0.6)
# (pattern, v, T): iterations from the nominal start, and at v + 0.1 from that solution, primal and dual; the cost.
GOLDEN = [
    ("0110/1100", 0.9, 0.6, 18, 6, 7103.3864),
    ("0111/1101", 0.2, 0.8, 17, 3, 8383.2337),
    ("0001/0100", 1.9, 1.4, 20, 6, 45930.855),
]


@pytest.fixture(scope="module")
def full(effort: Scenario) -> FixedGaitSolver:
    """On the paper's mesh."""
    return FixedGaitSolver(transcribe(effort), 20.0)


def attempted(solver: FixedGaitSolver, pattern: Pattern, speed: float, cycle: float) -> Attempt:
    task = at(speed, cycle)
    return solver.solve(pattern, task, nominal(solver.problem, task))


@pytest.mark.parametrize(("text", "speed", "cycle", "cold", "warm", "cost"), GOLDEN)
def test_iterations_cold_and_warm(
    full: FixedGaitSolver, text: str, speed: float, cycle: float, cold: int, warm: int, cost: float
) -> None:
    """Iterations, not seconds: a change of the problem or of the method that costs speed shows here."""
    pattern = Pattern.from_text(text)
    first = attempted(full, pattern, speed, cycle)
    assert first.feasible and first.method == "interior_point"
    assert first.cost == pytest.approx(cost, rel=1e-5)
    assert abs(first.iterations - cold) <= 2
    start = Start("neighbour", first.w, first.multipliers)
    second = full.solve(pattern, at(speed + 0.1, cycle), start)
    assert second.feasible and second.method == "interior_point"
    assert abs(second.iterations - warm) <= 2
    again = attempted(full, pattern, speed + 0.1, cycle)
    assert second.cost == pytest.approx(again.cost, rel=1e-5)


def test_an_attempt_tells_what_was_found(full: FixedGaitSolver, effort: Scenario) -> None:
    attempt = full.solve(GALLOP, TASK, nominal(full.problem, TASK))
    layout = full.problem.layout
    assert (attempt.start, attempt.solver_status, attempt.gave_up) == ("nominal", "converged", False)
    assert attempt.violation == worst(effort.as_data(), attempt.trajectory, TASK, GALLOP.text) <= FEASIBLE
    np.testing.assert_allclose(layout.pack(attempt.trajectory, 0.6), attempt.w, rtol=1e-12)
    h = np.diff(attempt.trajectory.times)
    assert attempt.cost == pytest.approx(h @ (attempt.trajectory.forces**2).sum(axis=(1, 2)))
    assert attempt.multipliers.bounds.shape == (layout.nw,)
    assert attempt.multipliers.rows.shape == (full.problem.ng,)
    assert attempt.cpu_s > 0 and attempt.wall_s > 0


def test_multipliers_balance_the_gradient(solver: FixedGaitSolver, problem: GaitProblem) -> None:
    """CasADi's signs: gradient + J^T rows + bounds = 0 on every variable that is not fixed."""
    attempt = solver.solve(GALLOP, TASK, nominal(problem, TASK))
    w, task, multipliers = ca.SX.sym("w", problem.layout.nw), TASK.parameters, attempt.multipliers
    cost, rows = problem.nlp(w, task)
    slope = ca.gradient(cost + ca.dot(multipliers.rows, rows), w) + multipliers.bounds
    left = ca.Function("left", [w], [slope])(attempt.w).full().ravel()
    assert np.abs(left[solver.method(GALLOP).space.free]).max() <= 2e-5 * max(1.0, attempt.cost / problem.cost_scale)


@pytest.fixture
def astray(monkeypatch: pytest.MonkeyPatch) -> None:
    """An interior point that never gets anywhere."""
    honest = InteriorPoint.follow

    def follow(self: InteriorPoint, task: object, start: object, unit: float, barrier: float, *_: object) -> Outcome:
        return honest(self, task, start, unit, barrier, 0)  # type: ignore[arg-type]

    monkeypatch.setattr(InteriorPoint, "follow", follow)


def test_agrees_with_ipopt_on_every_pattern(
    solver: FixedGaitSolver, problem: GaitProblem, request: pytest.FixtureRequest
) -> None:
    """Which gaits there are, and what they cost; a few end in other local optima."""
    patterns, start = all_patterns(2, 4, 1), nominal(problem, TASK)
    ours = [solver.solve(pattern, TASK, start) for pattern in patterns]
    request.getfixturevalue("astray")
    others = [solver.solve(pattern, TASK, start) for pattern in patterns]
    assert {attempt.method for attempt in others} == {"ipopt"}
    assert sum(attempt.method == "interior_point" for attempt in ours) >= len(ours) - 1
    assert [attempt.feasible for attempt in ours] == [attempt.feasible for attempt in others]
    costs = [(one.cost, other.cost) for one, other in zip(ours, others, strict=True) if one.feasible]
    assert len(costs) >= 20
    assert sum(one > other * (1 + 1e-5) for one, other in costs) <= 2


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
    full: FixedGaitSolver, effort: Scenario, text: str, speed: float, cycle: float
) -> None:
    robot, layout, task = effort.robot, full.problem.layout, at(speed, cycle)
    tries = [nominal(full.problem, task)]
    tries += [Start("r", starts.random(robot, layout, task, np.random.default_rng(seed))) for seed in range(2)]
    attempts = [full.solve(Pattern.from_text(text), task, start) for start in tries]
    assert not any(attempt.feasible for attempt in attempts)
    assert min(attempt.violation for attempt in attempts) > 1e-3
    assert not attempts[0].gave_up, "found infeasible, not merely left"


def test_what_is_found_infeasible_takes_few_iterations_and_no_ipopt(full: FixedGaitSolver) -> None:
    attempt = attempted(full, Pattern.from_text("0111/1101"), 6.0, 1.0)
    assert (attempt.method, attempt.solver_status) == ("interior_point", "infeasible")
    assert attempt.iterations <= 30


@pytest.mark.parametrize(("text", "speed", "cycle"), [
    ("0011/1100/1100/0011", 0.687429, 0.934165), ("0011/1110/1110/1001", 1.0, 0.4),
])  # fmt: skip
def test_a_gait_at_its_longest_stride_is_not_called_infeasible(
    checkout: Path, text: str, speed: float, cycle: float
) -> None:
    """Its multipliers grow as large as those of rows that cannot be met, but its rows are nearly met by then."""
    scenario = load_scenario(checkout / "configs/scenarios/anymal-flat-vibration.yaml")
    coarse = scenario.model_copy(update={"transcription": Transcription(knots_per_phase=4, min_phase_fraction=0.2)})
    attempt = attempted(FixedGaitSolver(transcribe(coarse), 20.0), Pattern.from_text(text), speed, cycle)
    assert attempt.feasible and attempt.method == "interior_point"
    assert attempt.iterations <= 50


def test_a_neighbour_that_misleads_proves_nothing(full: FixedGaitSolver) -> None:
    found = attempted(full, GALLOP, 0.9, 0.6)
    far = full.solve(GALLOP, at(6.0, 1.0), Start("neighbour", found.w, found.multipliers))
    assert not far.feasible
    assert far.gave_up
    assert far.method == "interior_point"


@pytest.mark.usefixtures("astray")
def test_ipopt_solves_what_the_interior_point_does_not(solver: FixedGaitSolver, problem: GaitProblem) -> None:
    attempt = solver.solve(GALLOP, TASK, nominal(problem, TASK))
    assert attempt.feasible
    assert (attempt.method, attempt.solver_status) == ("ipopt", "Solve_Succeeded")


@pytest.mark.usefixtures("astray")
def test_a_time_limit_gives_up(problem: GaitProblem) -> None:
    attempt = FixedGaitSolver(problem, 1e-4).solve(GALLOP, TASK, nominal(problem, TASK))
    assert attempt.gave_up
    assert not attempt.feasible
    assert "Time" in attempt.solver_status


@pytest.mark.usefixtures("astray")
@pytest.mark.parametrize("claim", ["Solve_Succeeded", "Solved_To_Acceptable_Level", "Maximum_Iterations_Exceeded"])
def test_a_solver_that_lies_is_not_believed(
    solver: FixedGaitSolver, problem: GaitProblem, monkeypatch: pytest.MonkeyPatch, claim: str
) -> None:
    """Success at an infeasible point proves nothing: neither that the gait can be walked nor that it cannot."""

    def lie(program: ca.Function, arguments: dict) -> tuple:
        blank = np.zeros(problem.ng)
        return claim, 7, {"x": arguments["x0"], "f": np.zeros(1), "lam_x": 0 * arguments["x0"], "lam_g": blank}

    monkeypatch.setattr(fixed_gait, "call_solver", lie)
    attempt = solver.solve(GALLOP, TASK, nominal(problem, TASK))
    assert attempt.violation > 1e-3
    assert not attempt.feasible
    assert attempt.gave_up


@pytest.mark.usefixtures("astray")
def test_a_feasible_point_short_of_the_minimum_is_not_solved(
    solver: FixedGaitSolver, problem: GaitProblem, solved: dict, monkeypatch: pytest.MonkeyPatch
) -> None:
    true, task = solved["gallop"].attempt, at(1.3, 0.6)

    def stopped(program: ca.Function, arguments: dict) -> tuple:
        blank = np.zeros(problem.ng)
        return "Maximum_CpuTime_Exceeded", 7, {"x": true.w, "f": np.ones(1), "lam_x": 0 * true.w, "lam_g": blank}

    monkeypatch.setattr(fixed_gait, "call_solver", stopped)
    attempt = solver.solve(GALLOP, task, nominal(problem, task))
    assert attempt.violation <= FEASIBLE
    assert not attempt.feasible


def test_a_start_that_is_not_a_number_fails(solver: FixedGaitSolver, problem: GaitProblem) -> None:
    attempt = solver.solve(GALLOP, TASK, Start("broken", np.full(problem.layout.nw, math.nan)))
    assert not attempt.feasible
    assert attempt.gave_up


def test_phases_that_just_fill_the_cycle_can_be_solved(effort: Scenario, solve: Solve) -> None:
    """Five phases of at least 0.2 T leave the durations no freedom at all."""
    transcription = Transcription(phases=5, knots_per_phase=4, min_phase_fraction=0.2)
    attempt = solve(effort.model_copy(update={"transcription": transcription}), "01100/11000", 0.5, 0.6)
    assert attempt.feasible
    np.testing.assert_allclose(attempt.trajectory.durations, 0.12, rtol=1e-6)


def test_the_least_used_pattern_is_forgotten(
    problem: GaitProblem, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fixed_gait, "KEPT", 2 * (len(program.hessian) + len(program.jacobian)))
    solver = FixedGaitSolver(problem, 20.0)
    one, two, three = (Pattern.from_text(text) for text in ("0110/1100", "0111/1101", "0001/0100"))
    first, second = solver.method(one), solver.method(two)
    assert solver.method(one) is first
    solver.method(three)
    assert solver.method(one) is first
    assert solver.method(two) is not second
