"""What a pattern costs at least, without solving it: sound, so what it rules out cannot be the best gait of a task.

Two terms of the objective have a floor that only the contact schedule decides, exact for the discrete problem too:

- force, eq. (8): a periodic motion's forces add up to the weight, sum_k h_k sum_l f = m g T, so by Cauchy-Schwarz
  the integral of their squares is at least (m g T)^2 / S, where S is how long all legs stand together;
- the base's velocity, eq. (9): in a flight phase it changes by g h every step, whatever it started with, so over n
  steps the sum of h (v - v0)^2 is at least g^2 h^3 n (n^2 - 1) / 12, and no phase is shorter than the least fraction.

They are integrals of different terms, so they add. A walk under J3 is cheap because it has neither: one solved
walk rules out most patterns of its task.
"""

from __future__ import annotations

import math

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern
from gaitflow.core.layout import GRAVITY
from gaitflow.search.screen import NO_ROOM, longest_support, why_no_gait

ROUNDING = 1e-6  # relative; what solvers of linear and nonlinear programs leave open


def ruled_out(
    scenario: Scenario, pattern: Pattern, speed: float, cycle_duration: float, incumbent: float = math.inf
) -> str | None:
    """Why the pattern cannot be the best at v [m/s], T [s]: impossible, or dearer than `incumbent` (unscaled cost).

    None when nothing here rules it out.
    """
    reason = why_no_gait(pattern, speed)
    if reason is not None:
        return reason
    least = least_cost(scenario, pattern, cycle_duration, _most_support(scenario, pattern, cycle_duration))
    if least <= incumbent:  # else the linear program could only confirm it
        support = longest_support(scenario, pattern, speed, cycle_duration)
        if support is None:
            return NO_ROOM
        least = least_cost(scenario, pattern, cycle_duration, support)
    return f"costs at least {least:.6g}, the incumbent {incumbent:.6g}" if least > incumbent else None


def least_cost(scenario: Scenario, pattern: Pattern, cycle_duration: float, support: float) -> float:
    """A floor of the unscaled cost over T [s] of any motion whose legs stand `support` [s] together at most."""
    robot, objective, settings = scenario.robot, scenario.objective, scenario.transcription
    slope, knots = math.radians(scenario.terrain.slope_deg), settings.knots_per_phase
    force = objective.force * (robot.mass * GRAVITY * cycle_duration) ** 2 / support
    step = settings.min_phase_fraction * cycle_duration / knots
    spread = GRAVITY**2 * step**3 * knots * (knots**2 - 1) / 12
    per_flight = spread * (
        objective.normal_velocity * math.cos(slope) ** 2 + objective.tangential_velocity * math.sin(slope) ** 2
    )
    flights = sum(not any(pattern.column(phase)) for phase in range(pattern.phases))
    return (force + flights * per_flight) * (1 - ROUNDING)


def _most_support(scenario: Scenario, pattern: Pattern, cycle_duration: float) -> float:
    """S [s] when every phase is as short as allowed but the one with most legs on the ground."""
    shortest = scenario.transcription.min_phase_fraction
    standing = [sum(pattern.column(phase)) for phase in range(pattern.phases)]
    return cycle_duration * (shortest * sum(standing) + (1 - shortest * pattern.phases) * max(standing))
