"""Two gaits of a small planar problem, solved."""

from __future__ import annotations

from dataclasses import dataclass

import pytest
from tasks_at import at
from to_solve import nominal

from gaitflow.config.scenario import Scenario, Transcription
from gaitflow.core.gaits import Pattern
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver
from gaitflow.solvers.point import GaitSpace, Point
from gaitflow.solvers.program import Program, derivatives

# A gait's pattern, and the speed [m/s] and cycle duration [s] that its start is solved for.
GAITS = {"walking": ("0111/1101", 0.3, 0.6), "gallop": ("0110/1100", 1.3, 0.6)}


@pytest.fixture(scope="session")
def problem(effort: Scenario) -> GaitProblem:
    """Least effort in the plane, 4 phases of 4 knots."""
    return transcribe(effort.model_copy(update={"transcription": Transcription(knots_per_phase=4)}))


@pytest.fixture(scope="session")
def evaluated(problem: GaitProblem) -> object:
    """The problem with its derivatives, as CasADi's function."""
    return derivatives(problem.separable)


@pytest.fixture
def program(problem: GaitProblem, evaluated: object) -> Program:
    return Program(problem.separable, evaluated)


@pytest.fixture(scope="session")
def solver(problem: GaitProblem) -> FixedGaitSolver:
    return FixedGaitSolver(problem, 20.0)


@dataclass(frozen=True)
class Solved:
    """A gait's bounds, and its motion at the task of GAITS as a point of cost / unit."""

    pattern: Pattern
    space: GaitSpace
    attempt: Attempt
    unit: float

    @property
    def point(self) -> Point:
        known = self.attempt.multipliers
        return self.space.split(self.attempt.w, known.bounds, known.rows, self.unit)


@pytest.fixture(scope="session")
def solved(problem: GaitProblem, solver: FixedGaitSolver) -> dict[str, Solved]:
    """Each gait by its name."""
    found = {}
    for gait, (text, speed, cycle) in GAITS.items():
        pattern, task = Pattern.from_text(text), at(speed, cycle)
        attempt = solver.solve(pattern, task, nominal(problem, task))
        assert attempt.feasible, attempt.solver_status
        unit = attempt.cost / problem.cost_scale
        found[gait] = Solved(pattern, solver.method(pattern).space, attempt, unit)
    return found
