"""Scenarios to solve: a planar pair of legs, and the same with few knots where the number does not matter."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from tasks_at import at

from gaitflow.config.scenario import Scenario, Transcription, load_scenario
from gaitflow.core.gaits import Pattern
from gaitflow.core.task import Task
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.search import starts
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Start

Solve = Callable[..., Attempt]


@pytest.fixture(scope="session")
def effort(checkout: Path) -> Scenario:
    """Least effort on flat ground, the paper's 4 phases of 10 knots."""
    return load_scenario(checkout / "tests/data/scenarios/planar-flat-effort.yaml")


@pytest.fixture(scope="session")
def coarse(effort: Scenario) -> Scenario:
    """The same with 3 knots a phase."""
    return effort.model_copy(update={"transcription": Transcription(knots_per_phase=3)})


@pytest.fixture(scope="session")
def anymal(checkout: Path) -> Scenario:
    """ANYmal in space, J3, 4 phases of 5 knots."""
    scenario = load_scenario(checkout / "tests/data/scenarios/anymal-flat-vibration.yaml")
    transcription = scenario.transcription.model_copy(update={"knots_per_phase": 5})
    return scenario.model_copy(update={"transcription": transcription})


def nominal(problem: GaitProblem, task: Task) -> Start:
    """The glide along the command, without multipliers."""
    return Start("nominal", starts.nominal(problem.scenario.robot, problem.layout, task))


@pytest.fixture(scope="session")
def solve() -> Solve:
    """One solve of a scenario's pattern and task from the nominal start; a solver is built once a scenario."""
    solvers: dict[str, FixedGaitSolver] = {}

    def solve(scenario: Scenario, pattern: str, speed: float, cycle_duration: float, **axes: float) -> Attempt:
        if scenario.problem_digest not in solvers:
            solvers[scenario.problem_digest] = FixedGaitSolver(transcribe(scenario), 20.0)
        solver = solvers[scenario.problem_digest]
        task = at(speed, cycle_duration, **axes)
        return solver.solve(Pattern.from_text(pattern), task, nominal(solver.problem, task))

    return solve
