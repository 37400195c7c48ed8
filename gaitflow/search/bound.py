"""What a pattern costs at least, without solving it: sound, so what it rules out cannot be the best gait of a task.

Two terms of the objective have a floor that only the contact schedule and the task decide, for every integrator:

- force, eq. (8): over a cycle the forces add up to m (a - g) T, a the mean acceleration, so by Cauchy-Schwarz the
  integral of their squares is at least (m |a - g| T)^2 / S, where S is how long all legs stand together;
- the base's velocity, eq. (9): in a flight of duration d it falls behind the commanded one by g + a a second, whatever
  it started with, so the integral of their squared difference is at least |g + a|^2 d^3 / 12, and no phase is shorter
  than the least fraction. With Euler's rule velocities count as they are at the start of their steps, which is less.

They are integrals of different terms, so they add. A walk under J3 is cheap because both are small for it: one solved
walk rules out most patterns of its task. In a turn only what is normal to the ground counts.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern
from gaitflow.core.layout import Layout
from gaitflow.core.task import Task
from gaitflow.search.screen import NO_ROOM, demand_of, longest_support, most_support, why_impossible

ROUNDING = 1e-6  # relative; what solvers of linear and nonlinear programs leave open


def ruled_out(scenario: Scenario, pattern: Pattern, task: Task, incumbent: float = math.inf) -> str | None:
    """Why the pattern cannot be the best at a task: impossible, or dearer than `incumbent` (unscaled cost).

    None when nothing here rules it out.
    """
    reason = why_impossible(scenario, pattern, task)
    if reason is not None or incumbent == math.inf:
        return reason
    least = least_cost(scenario, pattern, task, most_support(scenario, pattern, task))
    if least <= incumbent and scenario.objective.force:  # else the linear program could only confirm it
        support = longest_support(scenario, pattern, task)
        if support is None:
            return NO_ROOM
        least = least_cost(scenario, pattern, task, support)
    return f"costs at least {least:.6g}, the incumbent {incumbent:.6g}" if least > incumbent else None


def least_cost(scenario: Scenario, pattern: Pattern, task: Task, support: float) -> float:
    """A floor of the unscaled cost of any motion whose legs stand `support` [s] together at most."""
    objective, demand = scenario.objective, demand_of(scenario.robot, task)
    impulse = demand.mass * math.hypot(demand.normal, demand.along) * demand.cycle_duration
    falling = objective.normal_velocity * demand.normal**2 + objective.tangential_velocity * demand.along**2
    flights = sum(_spread(scenario, phases, demand.cycle_duration) for phases in _flights(pattern))
    return (objective.force * impulse**2 / support + falling * flights) * (1 - ROUNDING)


def _flights(pattern: Pattern) -> list[int]:
    """How many phases each flight of the cycle takes, in which no leg stands."""
    flying = "".join("0" if any(pattern.column(phase)) else "1" for phase in range(pattern.phases))
    if "0" not in flying:
        return [pattern.phases]
    cut = flying.index("0")
    return [len(run) for run in (flying[cut:] + flying[:cut]).split("0") if run]


def _spread(scenario: Scenario, phases: int, cycle_duration: float) -> float:
    """The least integral [s^3] of (t - t_0)^2 over a flight of this many phases, by the scenario's quadrature.

    Least where all phases are as short as allowed: a longer one moves instants away from t_0, and weighs them more.
    """
    settings = scenario.transcription
    shortest = settings.min_phase_fraction * cycle_duration
    if settings.integrator != "euler":
        return (phases * shortest) ** 3 / 12
    return shortest**3 * _spread_of_starts(phases, settings.knots_per_phase, settings.grading)


@lru_cache(maxsize=64)
def _spread_of_starts(phases: int, knots_per_phase: int, grading: float) -> float:
    """That integral by Euler's rule, over phases of duration 1."""
    one = Layout(2, 1, 1, knots_per_phase, 1.0, grading=grading)
    steps = np.tile(one.shares, phases)
    instants = np.cumsum(steps) - steps
    mean = steps @ instants / steps.sum()
    return float(steps @ (instants - mean) ** 2)
