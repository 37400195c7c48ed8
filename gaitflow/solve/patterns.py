"""Pattern search, ours: solve every pattern of a task that the screen lets through, each from its neighbour.

Where the paper restarts a MINLP, we try all canonical patterns: in the plane 36 with one stance per leg. A chain of
neighbouring tasks is solved in order, so that a pattern starts, primal and dual, from its solution at the task before.
The best few gaits of a task are then solved again from other starts, since every solve is only a local optimum.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence

import numpy as np

from gaitflow.gaits import Pattern, all_patterns, gait_of
from gaitflow.problem import transcribe
from gaitflow.scenario import Scenario
from gaitflow.solve import guess
from gaitflow.solve.nlp import Attempt, FixedGaitSolver, Start
from gaitflow.solve.screen import why_impossible
from gaitflow.solve.solution import Solution
from gaitflow.task import Task

RECHECKED_GAITS = 3
SAME_COST = 1e-6  # relative; a recheck replaces a solution only when it is better by more


def candidate_patterns(scenario: Scenario) -> tuple[Pattern, ...]:
    """The patterns to try: the given one (fixed_gait), or all representatives under the stance setting."""
    if scenario.strategy.pattern is not None:
        return (Pattern.from_text(scenario.strategy.pattern),)
    robot = scenario.robot
    mirror = robot.mirror_permutation if robot.mirror else None
    return all_patterns(len(robot.legs), scenario.transcription.phases, scenario.stances_per_leg, mirror)


def solve_chain(scenario: Scenario, tasks: Sequence[Task]) -> list[Solution]:
    """Solve a chain of neighbouring tasks; a row per task and pattern, in that order, screened ones included."""
    solver = FixedGaitSolver(transcribe(scenario), scenario.strategy.solve_time_limit)
    patterns = candidate_patterns(scenario)
    rows: list[Solution] = []
    before: dict[Pattern, Attempt] = {}
    first = True
    for task in tasks:
        attempts: dict[Pattern, list[Attempt]] = {}
        reasons: dict[Pattern, str] = {}
        for pattern in patterns:
            reason = why_impossible(scenario, pattern, task.speed, task.cycle_duration)
            if reason is not None:
                reasons[pattern] = reason
                continue
            # A pattern that just failed at the neighbour is not worth random starts here.
            restarts = scenario.strategy.restarts if first or pattern in before else 0
            attempts[pattern] = _until_feasible(solver, pattern, task, before.get(pattern), restarts)
        for pattern in _leaders(scenario, attempts):
            attempts[pattern] += _recheck(solver, pattern, task, attempts[pattern])
        for pattern in patterns:
            if pattern in reasons:
                rows.append(screened(scenario, task, pattern, reasons[pattern]))
            else:
                rows.append(solution(scenario, task, pattern, attempts[pattern]))
        before = {pattern: best for pattern, tried in attempts.items() if (best := best_of(tried)) is not None}
        first = False
    return rows


def best_of(attempts: Sequence[Attempt]) -> Attempt | None:
    """The cheapest feasible attempt; of equals within SAME_COST the earliest."""
    best: Attempt | None = None
    for attempt in attempts:
        if attempt.feasible and (best is None or attempt.cost < best.cost - SAME_COST * abs(best.cost)):
            best = attempt
    return best


def seed_of(*parts: object) -> int:
    """A seed that depends on the parts alone, so that a unit solves the same wherever it runs."""
    return int.from_bytes(hashlib.sha256(repr(parts).encode()).digest()[:8], "big")


def solution(scenario: Scenario, task: Task, pattern: Pattern, attempts: Sequence[Attempt]) -> Solution:
    """The dataset row of one pattern at one task from all that was tried."""
    best = best_of(attempts)
    kept = best or min(attempts, key=lambda attempt: attempt.violation)
    if best is not None:
        status = "solved"
    else:
        status = "failed" if all(attempt.gave_up for attempt in attempts) else "infeasible"
    return Solution(
        speed=task.speed,
        cycle_duration=task.cycle_duration,
        split=task.split,
        pattern=pattern.text,
        gait=_gait_text(scenario, pattern),
        strategy=scenario.strategy.name,
        start=kept.start,
        seed=scenario.strategy.seed,
        status=status,  # type: ignore[arg-type]
        solver_status=kept.solver_status,
        cost=best.cost if best else float("nan"),
        violation=kept.violation,
        iterations=sum(attempt.iterations for attempt in attempts),
        solves=len(attempts),
        wall_s=sum(attempt.wall_s for attempt in attempts),
        cpu_s=sum(attempt.cpu_s for attempt in attempts),
        trajectory=best.trajectory if best else None,
        multipliers=best.multipliers if best else None,
    )


def screened(scenario: Scenario, task: Task, pattern: Pattern, reason: str) -> Solution:
    """The dataset row of a pattern that a necessary condition rules out."""
    nan = float("nan")
    return Solution(
        task.speed, task.cycle_duration, task.split, pattern.text, _gait_text(scenario, pattern),
        scenario.strategy.name, "", scenario.strategy.seed, "screened", reason, nan, nan, 0, 0, 0.0, 0.0,
    )  # fmt: skip


def _gait_text(scenario: Scenario, pattern: Pattern) -> str:
    robot = scenario.robot
    return gait_of(pattern, robot.mirror_permutation if robot.mirror else None).text


def _until_feasible(
    solver: FixedGaitSolver, pattern: Pattern, task: Task, neighbour: Attempt | None, restarts: int
) -> list[Attempt]:
    attempts: list[Attempt] = []
    for start in _starts(solver, pattern, task, neighbour, restarts):
        # Where the solver ended at a point of local infeasibility, a random start never helped: see DESIGN.md.
        if start.name.startswith("random") and not any(attempt.gave_up for attempt in attempts):
            break
        attempts.append(solver.solve(pattern, task.speed, task.cycle_duration, start))
        if attempts[-1].feasible:
            break
    return attempts


def _starts(
    solver: FixedGaitSolver, pattern: Pattern, task: Task, neighbour: Attempt | None, restarts: int
) -> Iterator[Start]:
    if neighbour is not None:
        yield Start("neighbour", neighbour.w, neighbour.multipliers)
    problem = solver.problem
    robot, layout = problem.scenario.robot, problem.layout
    yield Start("nominal", guess.nominal(robot, layout, task.speed, task.cycle_duration))
    for number in range(restarts):
        yield _random_start(solver, pattern, task, number)


def _random_start(solver: FixedGaitSolver, pattern: Pattern, task: Task, number: int) -> Start:
    problem = solver.problem
    seed = seed_of(problem.scenario.strategy.seed, pattern.text, task.speed, task.cycle_duration, number)
    w = guess.random(
        problem.scenario.robot, problem.layout, task.speed, task.cycle_duration, np.random.default_rng(seed)
    )
    return Start(f"random-{number}", w)


def _leaders(scenario: Scenario, attempts: dict[Pattern, list[Attempt]]) -> list[Pattern]:
    """The best pattern of each of the cheapest gaits."""
    best = {pattern: found.cost for pattern, tried in attempts.items() if (found := best_of(tried)) is not None}
    leaders: dict[str, Pattern] = {}
    for pattern in sorted(best, key=lambda pattern: (best[pattern], pattern)):
        leaders.setdefault(_gait_text(scenario, pattern), pattern)
    return list(leaders.values())[:RECHECKED_GAITS]


def _recheck(solver: FixedGaitSolver, pattern: Pattern, task: Task, done: Sequence[Attempt]) -> list[Attempt]:
    """Other basins: the nominal start if it was not tried, and one random start."""
    tried = {attempt.start for attempt in done}
    problem = solver.problem
    starts = [
        Start("nominal", guess.nominal(problem.scenario.robot, problem.layout, task.speed, task.cycle_duration)),
        _random_start(solver, pattern, task, 0),
    ]
    return [
        solver.solve(pattern, task.speed, task.cycle_duration, start) for start in starts if start.name not in tried
    ]
