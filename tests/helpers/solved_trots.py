"""Trots of ANYmal at tasks that its map does not have: turning, sideways, on slopes, with a load."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.core.gaits import Pattern
from gaitflow.motion import Motion
from gaitflow.problem import transcribe
from gaitflow.search import starts
from gaitflow.solvers.fixed_gait import FixedGaitSolver, Start

SCENARIO = Path(__file__).resolve().parents[2] / "configs/scenarios/anymal-exact-vibration.yaml"
TROT = "0011/1100/1100/0011"  # LF, RF, LH, RH
LEVEL = {"lateral_speed": (-0.5, 0.5), "yaw_rate": (-1.0, 1.0)}
HILL = {"lateral_speed": (-0.5, 0.5), "slope": (-20.0, 20.0)}  # nobody turns periodically on a slope


def solved_trot(**axes: float) -> Motion:
    """The base's motion at a task of 0.6 s a cycle with these values; the other axes are 0, friction 0.8."""
    ground = "slope" if "slope" in axes else "level"
    scenario, solver = _solver(ground)
    space = scenario.tasks.space
    values = dict.fromkeys(space.ranged, 0.0) | {"friction": 0.8, "cycle_duration": 0.6} | axes
    task, problem = space.task(values), solver.problem
    start = Start("nominal", starts.nominal(scenario.robot, problem.layout, task))
    attempt = solver.solve(Pattern.from_text(TROT), task, start)
    assert attempt.feasible, (axes, attempt.solver_status)
    return Motion.of(scenario.as_data(), attempt.trajectory, task, TROT, point="base")


@cache
def _solver(ground: str) -> tuple[Scenario, FixedGaitSolver]:
    scenario = load_scenario(SCENARIO)
    ranges = {"speed": (-1.0, 1.6), "payload": (0.0, 10.0), "friction": (0.3, 1.0)}
    ranges |= HILL if ground == "slope" else LEVEL
    tasks = scenario.tasks.as_data()
    tasks["axes"] |= {axis: {"start": low, "stop": high, "count": 2} for axis, (low, high) in ranges.items()}
    coarse = scenario.transcription.model_copy(update={"knots_per_phase": 5})
    scenario = scenario.model_copy(update={"tasks": scenario.tasks.from_data(tasks, "trots"), "transcription": coarse})
    return scenario, FixedGaitSolver(transcribe(scenario), 20.0)
