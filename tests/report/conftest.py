"""A small map of the half-cheetah as the paper's Fig. 4a describes it, with motions that look like gaits.

The trajectories are drawn by hand-made formulas (half-sine forces that carry the weight, feet that follow the ground),
not solved: the report must show whatever it is given.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gaitflow.config.robot import load_robot
from gaitflow.config.scenario import Scenario, Tasks, load_scenario
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.task_space import TaskSpace
from gaitflow.core.trajectory import Trajectory
from gaitflow.dataset import Solutions, load_solutions
from gaitflow.problem import transcribe
from gaitflow.search import starts as guess
from gaitflow.search.rows import solution as row_of
from gaitflow.search.solution import Solution
from gaitflow.solvers.fixed_gait import FixedGaitSolver, Start

CONFIGS = Path(__file__).parents[2] / "configs"
ROBOT = Path(__file__).parents[1] / "data" / "robots" / "planar.yaml"  # stays as it is when the shipped one changes
PATTERNS = {  # four-phase patterns of the gaits of Fig. 5
    "walking": "0111/1101",
    "gallop": "0110/1100",
    "bounding": "0001/0100",
    "pronking": "0110/0100",
    "gallop-walk": "0011/0110",
    "gallop-pronk": "0010/0110",
    "gallop-bound": "0010/0100",
}
GRAVITY = 9.81
SPEEDS = np.round(np.linspace(0.1, 2.3, 12), 9)
DURATIONS = np.round(np.linspace(0.4, 1.6, 7), 9)


def paper_gait(speed: float, duration: float) -> str:
    """Section IV.A's words on Fig. 4a as a rule."""
    if speed <= 0.3:
        return "walking"
    if speed <= 0.7:
        return "gallop-walk"
    if duration >= 1.2 and speed >= 1.7:
        return "bounding"
    if duration >= 1.2 and speed >= 1.5:
        return "gallop-bound"
    if speed <= 0.9 and 0.8 <= duration <= 1.0:
        return "pronking"
    return "gallop"


def label_row(speed: float, duration: float, gait: str, split: str = "grid") -> dict[str, object]:
    pattern = PATTERNS[gait]
    slow = speed < 0.2
    return {
        "speed": speed,
        "cycle_duration": duration,
        "split": split,
        "status": "solved",
        "gait": gait,
        "gait_key": gait_of(Pattern.from_text(pattern)).text,
        "pattern": pattern,
        "cost": 9000.0 * duration * (1 + 0.3 * speed),
        "margin": 4e-4 if slow else 0.02 * (1 + speed),
        "runner_up": "gallop-walk" if gait == "walking" else "walking",
        "ties": [gait, "gallop-walk"] if slow else [gait],
        "label": gait,
    }


def make_labels(rule=paper_gait, speeds=SPEEDS, durations=DURATIONS) -> pd.DataFrame:
    return pd.DataFrame([label_row(float(v), float(t), rule(v, t)) for v in speeds for t in durations])


def infeasible_row(speed: float, duration: float) -> dict[str, object]:
    empty = dict.fromkeys(["gait", "gait_key", "pattern", "runner_up", "label"], "")
    task = {"speed": speed, "cycle_duration": duration, "split": "grid", "status": "infeasible"}
    return {**task, **empty, "cost": np.nan, "margin": np.nan, "ties": []}


def make_trajectory(scenario: Scenario, speed: float, duration: float, pattern: str) -> Trajectory:
    robot, knots = scenario.robot, scenario.transcription.knots_per_phase
    rows = pattern.split("/")
    phases = len(rows[0])
    fractions = 1 + 0.3 * np.sin(speed + np.arange(phases))
    durations = duration * fractions / fractions.sum()
    steps = np.repeat(durations / knots, knots)
    times = np.concatenate([[0.0], np.cumsum(steps)])
    stance = np.array([np.repeat([int(c) for c in row], knots) for row in rows], dtype=bool).T
    starts = np.concatenate([[0.0], np.cumsum(durations)])[:-1]
    forces = np.zeros((len(steps), len(rows), 2))
    feet = np.zeros((len(times), len(rows), 2))
    for leg, row in enumerate(rows):
        # Cut at a swing phase, so that the stance is one piece of the cycle.
        first = next(i for i in range(phases) if row[i] == "1" and row[i - 1] == "0")
        standing = sum(durations[i] for i in range(phases) if row[i] == "1")
        phase = np.mod(times - starts[first], duration)
        forces[:, leg, 1] = np.where(stance[:, leg], np.sin(np.pi * np.clip(phase[:-1] / standing, 0, 1)) + 0.05, 0)
        share = np.clip((phase - standing) / (duration - standing), 0, 1)
        hip = robot.legs[leg].default_foot[0]
        travel = np.where(phase <= standing, standing / 2 - phase, (share - 0.5) * standing)
        feet[:, leg, 0] = hip + speed * (times + travel)
        feet[:, leg, 1] = 0.12 * np.sin(np.pi * share)
    forces *= robot.mass * GRAVITY * duration / (forces[:, :, 1].sum(axis=1) @ steps)
    forces[:, :, 0] = 0.15 * forces[:, :, 1] * np.cos(2 * np.pi * times[:-1, None] / duration)
    base = np.zeros((len(times), 6))
    base[:, 0], base[:, 3] = speed * times, speed
    rise = np.cumsum(np.concatenate([[0], steps * (forces[:, :, 1].sum(axis=1) / robot.mass - GRAVITY)]))
    base[:, 4] = rise - np.trapezoid(rise, times) / duration
    base[:, 1] = 0.5 + np.concatenate([[0], np.cumsum(steps * base[:-1, 4])])
    base[:, [1, 4]] *= 0.05 / max(np.ptp(base[:, 1]), 1e-9)
    base[:, 1] += 0.5 - base[:, 1].mean()
    base[:, 2] = 0.05 * (1 + speed) * np.sin(2 * np.pi * times / duration)
    base[:, 5] = np.gradient(base[:, 2], times)
    return Trajectory(times, base, feet, forces, forces, np.gradient(feet, times, axis=0)[:-1], durations)


def make_solution(scenario: Scenario, row: dict) -> Solution:
    speed, duration, pattern = row["speed"], row["cycle_duration"], row["pattern"]
    values = {axis: row[axis] for axis in scenario.tasks.space.ranged}
    return Solution(
        task=scenario.tasks.space.task(values, row["split"]),
        pattern=pattern,
        gait=row["gait_key"],
        strategy="patterns",
        start="neighbour",
        seed=0,
        status="solved",
        solver_status="Solve_Succeeded",
        cost=row["cost"],
        violation=3e-9,
        iterations=20,
        solves=1,
        wall_s=0.03,
        cpu_s=0.03,
        trajectory=make_trajectory(scenario, speed, duration, pattern),
    )


def without_trajectory(solution: Solution, status: str) -> Solution:
    changed = {"status": status, "pattern": "1111/0000", "cost": float("nan"), "violation": float("nan")}
    return Solution(**{**vars(solution), **changed, "trajectory": None})


@pytest.fixture(scope="session")
def scenario() -> Scenario:
    scenario = load_scenario(CONFIGS / "scenarios" / "half-cheetah-flat-effort.yaml")
    return scenario.model_copy(update={"robot": load_robot(ROBOT)})


@pytest.fixture(scope="session")
def space(scenario: Scenario) -> TaskSpace:
    return scenario.tasks.space


@pytest.fixture(scope="session")
def tasks(scenario: Scenario) -> Tasks:
    return scenario.tasks


def over(scenario: Scenario, **axes: object) -> Scenario:
    """The same with other axes."""
    return scenario.model_copy(update={"tasks": Tasks.from_data({"axes": axes}, "tasks")})


@pytest.fixture(scope="session")
def sloped(scenario: Scenario) -> Scenario:
    """The same over 12 slopes, too."""
    axes = scenario.tasks.as_data()["axes"]
    return over(scenario, **{**axes, "slope": {"start": -22.0, "stop": 22.0, "count": 12}})


@pytest.fixture(scope="session")
def sloped_labels(map_of) -> pd.DataFrame:
    """The steeper the slower: on every slope the rule at another speed; and one held-out task between."""
    frames = [
        map_of(lambda v, t, at=at: paper_gait(v * (1 + abs(at) / 44), t)).assign(slope=at)
        for at in np.linspace(-22.0, 22.0, 12)
    ]
    frames.append(pd.DataFrame([label_row(1.0, 0.9, "gallop", "held_out") | {"slope": 1.7}]))
    return pd.concat(frames, ignore_index=True)


def turning_gait(speed: float, lateral: float, yaw: float, duration: float) -> str:
    """The rule of the plane, at a speed that grows with steps to the side and with turning to the left."""
    return paper_gait(speed * (1 + abs(lateral)) + max(yaw, 0), duration)


@pytest.fixture(scope="session")
def turning(scenario: Scenario) -> Scenario:
    """The same over four axes, whose tasks choose themselves: 5 values of lateral speed by 4 of yaw rate."""
    data = scenario.tasks.as_data()["axes"] | {
        "lateral_speed": {"start": -0.4, "stop": 0.4, "count": 5},
        "yaw_rate": {"start": -0.6, "stop": 0.6, "count": 4},
    }
    return scenario.model_copy(update={"tasks": Tasks.from_data({"axes": data, "sampling": "adaptive"}, "tasks")})


@pytest.fixture(scope="session")
def turning_labels(turning: Scenario) -> pd.DataFrame:
    """300 tasks anywhere in the box that the map is made from, and 60 held-out ones."""
    rng = np.random.default_rng(3)
    rows = []
    for number in range(360):
        at = {axis: float(rng.uniform(values.start, values.stop)) for axis, values in turning.tasks.ranges.items()}
        row = label_row(at["speed"], at["cycle_duration"], turning_gait(*at.values()))
        rows.append(row | at | {"split": "sampled" if number < 300 else "held_out"})
    return pd.DataFrame(rows)


@pytest.fixture(scope="session")
def turning_select(gaits: list[str]):
    """The rule of four axes as a map would answer it."""

    def answer(values: Mapping[str, np.ndarray]) -> np.ndarray:
        places = zip(*(values[axis] for axis in ("speed", "lateral_speed", "yaw_rate", "cycle_duration")), strict=True)
        return np.array([gaits.index(turning_gait(*place)) for place in places])

    return answer


@pytest.fixture(scope="session")
def anymal(checkout: Path) -> Scenario:
    """ANYmal in space, J3, 4 phases of 10 knots."""
    return load_scenario(checkout / "tests/data/scenarios/anymal-flat-vibration.yaml")


@pytest.fixture(scope="session")
def solved(anymal: Scenario):
    """(speed, duration, pattern) -> solution of ANYmal, really solved."""
    solver = FixedGaitSolver(transcribe(anymal), 20.0)

    def solve(speed: float, duration: float, pattern: str) -> Solution:
        task = anymal.tasks.space.task({"speed": speed, "cycle_duration": duration})
        start = Start("nominal", guess.nominal(anymal.robot, solver.problem.layout, task))
        attempt = solver.solve(Pattern.from_text(pattern), task, start)
        assert attempt.feasible, attempt.solver_status
        return row_of(anymal, task, Pattern.from_text(pattern), [attempt])

    return solve


@pytest.fixture(scope="session")
def trot(solved) -> Solution:
    """ANYmal's walking trot at the speed and duration of the paper's hardware trial."""
    return solved(0.3, 0.8, "0111/1101/1101/0111")


@pytest.fixture(scope="session")
def published(checkout: Path) -> Solutions:
    """A published dataset of the half-cheetah."""
    return load_solutions(checkout / "datasets/half-cheetah-flat-effort/1.0.0")


@pytest.fixture(scope="session")
def labels() -> pd.DataFrame:
    """The grid of Fig. 4a, one task of it infeasible, the slowest ones tied, and 25 held-out tasks."""
    rng = np.random.default_rng(7)
    rows = make_labels().to_dict("records")
    rows[6] = infeasible_row(0.1, 1.6)
    for _ in range(25):
        v, t = float(rng.uniform(0.1, 2.3)), float(rng.uniform(0.4, 1.6))
        rows.append(label_row(v, t, paper_gait(v, t), "held_out"))
    return pd.DataFrame(rows)


@pytest.fixture(scope="session")
def solutions(scenario: Scenario, labels: pd.DataFrame) -> list[Solution]:
    """The solution of each label, and the other ends that a pattern's solve can come to."""
    rows = labels[labels["status"] == "solved"].to_dict("records")
    solved = [make_solution(scenario, row) for row in rows]
    ends = ("screened", "screened", "infeasible", "failed", "probed", "probed", "probed")
    others = [without_trajectory(solved[0], status) for status in ends]
    return solved + others


@pytest.fixture(scope="session")
def gaits() -> list[str]:
    return sorted(PATTERNS)


@pytest.fixture(scope="session")
def select(gaits: list[str]):
    """The rule as a classifier would answer it."""

    def answer(values: Mapping[str, np.ndarray]) -> np.ndarray:
        tasks = zip(values["speed"], values["cycle_duration"], strict=True)
        return np.array([gaits.index(paper_gait(v - 0.1, t + 0.1)) for v, t in tasks])

    return answer


@pytest.fixture(scope="session")
def map_of():
    """(rule, speeds=..., durations=...) -> labels frame of that rule on the grid."""
    return make_labels


@pytest.fixture(scope="session")
def rule_4a():
    return paper_gait


@pytest.fixture(scope="session")
def infeasible():
    """(speed, duration) -> row of a labels frame."""
    return infeasible_row


@pytest.fixture(scope="session")
def solution_of(scenario: Scenario):
    """(speed, duration, gait) -> solution with a trajectory."""
    return lambda speed, duration, gait: make_solution(scenario, label_row(speed, duration, gait))


def quality(accuracy: float) -> dict[str, float | int | None]:
    return {
        "tasks": 40,
        "accuracy": accuracy,
        "macro_f1": accuracy - 0.03,
        "top1_beyond_ties": accuracy + 0.02,
        "regret_mean": 0.0021,
        "regret_p95": 0.011,
        "infeasible_rate": 0.0,
        "infeasible_top2": None,
    }


@pytest.fixture(scope="session")
def learning() -> dict:
    competitors = [
        {"method": name, "cross_validation": quality(value), "held_out": quality(value - 0.01)}
        for name, value in (("mlp", 0.95), ("svm", 0.93), ("forest", 0.9), ("knn", 0.88))
    ]
    return {"method": "svm", "rule": "the least regret", "remarks": ["one fold is small"], "competitors": competitors}


@pytest.fixture(scope="session")
def record(scenario: Scenario) -> dict:
    maker = {
        "code": {"version": "0.1.0", "commit": "0123abc", "dirty": True},
        "packages": {"casadi": "3.8.2", "numpy": "2.4.6"},
        "python": "3.11.2",
        "system": "Linux x86_64",
        "cpu": "Example CPU",
    }
    return {
        "scenario_digest": scenario.problem_digest,
        "units": 14,
        "units_digest": "ab" * 32,
        "made_by": [maker],
        "created": "2026-01-01T00:00:00+00:00",
    }
