"""A map's pick, its other gaits and hand-made ones, each followed by one controller in MuJoCo: does the pick hold?"""

from __future__ import annotations

import math
import statistics
import sys
from collections.abc import Iterator, Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy.stats import kendalltau

from benchmarks.clients.tasks import asked_plans
from benchmarks.document import document
from benchmarks.rows import Row, RowStore
from gaitflow.clients.default_gaits import Kind, default_motion
from gaitflow.clients.description import RobotDescription, describe
from gaitflow.clients.robot_model import RobotModel
from gaitflow.clients.shooting import shoot
from gaitflow.clients.simulation import AS_PLANNED, Conditions, Push
from gaitflow.clients.walking import walk
from gaitflow.clients.whole_body import WholeBody, load_whole_body
from gaitflow.config.scenario import Scenario
from gaitflow.core import check
from gaitflow.core.layout import GRAVITY
from gaitflow.motion import Motion
from gaitflow.runtime import GaitMap, Plan
from gaitflow.urdf.mechanism import load_mechanism

CYCLES = 10
OTHER_GAITS = 5  # of the map, those that it ranks next
HAND_MADE: tuple[tuple[Kind, float], ...] = (
    ("trot", 0.4), ("trot", 0.5), ("trot", 0.6), ("walk", 0.75), ("pace", 0.5), ("bound", 0.5),
)  # fmt: skip
STALL = 0.1  # a motor's effort limit over the torque that it could hold at no speed
NEAR = 0.05  # of the best cost of transport, which is as good
DISTURBED: dict[str, Conditions] = {
    "friction 0.5": Conditions(friction=0.5),
    "mass -10 %": Conditions(mass_factor=0.9),
    "mass +10 %": Conditions(mass_factor=1.1),
    "5 ms late": Conditions(delay=0.005),
    "pushed": Conditions(pushes=tuple(Push(2.0 + i, (0.0, 0.3 * (-1) ** i, 0.0)) for i in range(3))),
}
NOTES = (
    "tasks: random speeds, with the cycle duration that the map chooses there or one up to a quarter off",
    "cost_of_transport: positive mechanical work of all joints over m g distance; energy: with the heat of torques, "
    "tau^2 times a tenth of (speed limit / effort limit) of the hip flexion motor, the same rule for every robot",
    "model: the map's objective of the motion that is followed, over m g times the commanded distance; a cost of "
    "transport only where that is energy; kendall: over all gaits of a task that walk, and over the map's own alone",
    "all gaits are followed by the same controller, with swings of the same height; two cycles, then ten are measured",
    "a gait that does not walk is dearer than any that does; the best trot is the best hand-made one that walks",
    "crocoddyl: FDDP's final cost of two cycles of the same motion, null where it finds none",
)


class Case(NamedTuple):
    """A gait to walk in: where it comes from, its name, what the map's objective says of it, its motion.

    The objective says nothing where legs are too short for the motion.
    """

    source: Literal["pick", "map", "hand-made"]
    gait: str
    model: float | None
    motion: Motion


def run(scenario: Scenario, artifact: Path, runs: Path, tasks: int = 24, seed: int = 0) -> dict[str, Any]:
    """The document: a row a task, gait and condition. Raises ConfigError where the robot's description is missing."""
    bench = _Bench(artifact, seed, tasks)
    about = {"artifact": bench.gait_map.manifest.version, "digest": bench.gait_map.manifest.scenario_digest}
    store = RowStore("walk", scenario, runs, [sys.modules[__name__]], {key: str(value) for key, value in about.items()})
    keys = [{"task": number, "seed": seed} for number in range(tasks)]
    rows = [
        {**row["at"], **each}
        for row in store.rows(keys, lambda key: bench.task(int(key["task"])))
        for each in row["rows"]
    ]
    done = document("walk", bench.gait_map.manifest.name, rows, summary(rows), NOTES)
    done["versions"] |= {name: version(name) for name in ("mujoco", "crocoddyl", "pin")}
    return done


class _Bench:
    """A map, its robot's description, and the plans of random tasks."""

    def __init__(self, artifact: Path, seed: int, tasks: int) -> None:
        self.gait_map = GaitMap.load(artifact)
        self._scenario = self.gait_map.manifest.scenario
        self._plans = cache(lambda: list(asked_plans(self.gait_map, tasks, seed)))
        self._description: RobotDescription = describe(self._scenario)
        self._body: WholeBody = load_whole_body(self._description.urdf.path, self._scenario)
        self._heat = heat_of(self._description)

    def task(self, number: int) -> Row:
        """The walks at one task."""
        plan = self._plans()[number]
        motion = plan.motion(point="base")
        robot = RobotModel.of(self._description, self._scenario, motion.task)
        cases = list(self._cases(plan))
        rows = [self._row(robot, case, "as planned") for case in cases]
        best = _best([row for row in rows if row["source"] == "hand-made" and row["gait"].startswith("trot")])
        for case in cases:
            if case.source == "pick" or (best is not None and case.gait == best["gait"]):
                rows += [self._row(robot, case, name) for name in DISTURBED]
        return {"at": dict(plan.task), "rows": rows}

    def _cases(self, plan: Plan) -> Iterator[Case]:
        yield self._planned("pick", plan)
        asked: dict[str, Any] = dict(plan.task)
        ranked = [gait for gait, _ in self.gait_map.select(**asked).ranked if gait != plan.gait]
        others = [self.gait_map.plan(gait=gait, **asked) for gait in ranked[:OTHER_GAITS]]
        yield from (self._planned("map", other) for other in others if other.feasible)
        task = plan.motion().task
        for kind, duty in HAND_MADE:
            motion = default_motion(self._scenario, kind, task, duty, plan.swing_apex)
            with np.errstate(invalid="ignore"):
                model = check.cost(self._scenario, motion.trajectory, task, motion.pattern) / self._weight_moved(motion)
            yield Case("hand-made", f"{kind} of duty {duty:g}", model if math.isfinite(model) else None, motion)

    def _planned(self, source: Literal["pick", "map"], plan: Plan) -> Case:
        motion = plan.motion(point="base")
        return Case(source, plan.gait, plan.cost / self._weight_moved(motion), motion)

    def _weight_moved(self, motion: Motion) -> float:
        """m g times the distance [J] of a cycle."""
        away = math.hypot(motion.task["speed"], motion.task["lateral_speed"]) * motion.period
        return (float(self._scenario["robot"]["mass"]) + motion.task["payload"]) * GRAVITY * away

    def _row(self, robot: RobotModel, case: Case, conditions: str) -> Row:
        record = walk(robot, case.motion, CYCLES, DISTURBED.get(conditions, AS_PLANNED)).record
        heat = self._heat * record.heat / (robot.mass * GRAVITY * abs(record.distance)) if record.distance else math.inf
        row: Row = {"source": case.source, "gait": case.gait, "conditions": conditions, "model": case.model}
        work = math.inf if record.cost_of_transport is None else record.cost_of_transport
        row |= {**record.as_data(), "energy": work + heat}
        if conditions == "as planned":
            row["crocoddyl"] = self._shot(case.motion)
        return row

    def _shot(self, motion: Motion) -> float | None:
        shot = shoot(self._body, motion)
        return shot.cost if shot.ready else None


def heat_of(description: RobotDescription) -> float:
    """W/(N m)^2 of the hip flexion motor, by its limits: the heat R tau^2 / k^2 at stall is torque times no-load speed.

    0 for a URDF without limits.
    """
    mechanism = load_mechanism(description.urdf)
    joint = mechanism.joints_of([foot.link for foot in description.feet])[0][1]
    ratio = mechanism.velocity[joint] / mechanism.effort[joint]
    return float(STALL * ratio) if np.isfinite(ratio) else 0.0


def summary(rows: Sequence[Row]) -> dict[str, Any]:
    """The yardstick's numbers over all tasks."""
    planned = [row for row in rows if row["conditions"] == "as planned"]
    judged = [_judge(group) for group in _by_task(planned)]
    return {
        "tasks": len(judged),
        "picks_walked": sum(each["walked"] for each in judged),
        "picks_at_most_the_best_trot": sum(each["beats_trot"] for each in judged),
        "picks_near_the_best": sum(each["near"] for each in judged),
        "energy_over_best_trot_median": _median([each["over_trot"] for each in judged]),
        "regret_median": _median([each["regret"] for each in judged]),
        "regret_worst": max((each["regret"] for each in judged if each["regret"] is not None), default=None),
        "kendall_median": _median([each["kendall"] for each in judged]),
        "kendall_of_own_median": _median([each["kendall_of_own"] for each in judged]),
        "energy_of_picks_median": _median([each["energy"] for each in judged]),
        "crocoddyl_over_best_trot_median": _median([each["crocoddyl"] for each in judged]),
        "walked": {
            source: {name: f"{sum(r['walked'] for r in found)} of {len(found)}" for name, found in by.items() if found}
            for source, by in (
                (source, {name: [r for r in rows if r["conditions"] == name and _source(r) == source]
                          for name in ("as planned", *DISTURBED)})
                for source in ("pick", "map", "trot", "hand-made")
            )
        },
    }  # fmt: skip


def _source(row: Row) -> str:
    return "trot" if row["source"] == "hand-made" and str(row["gait"]).startswith("trot") else str(row["source"])


def _judge(group: Sequence[Row]) -> dict[str, Any]:
    """One task: how the map's pick did among all."""
    pick = next(row for row in group if row["source"] == "pick")
    best, trot = _best(group), _best([row for row in group if _source(row) == "trot"])
    all_walked = [row for row in group if row["walked"]]
    walked = bool(pick["walked"])
    shots = [row["crocoddyl"] for row in group if _source(row) == "trot" and row["crocoddyl"] is not None]
    return {
        "walked": walked,
        "energy": pick["energy"] if walked else None,
        "beats_trot": walked and (trot is None or pick["energy"] <= trot["energy"]),
        "near": walked and best is not None and pick["energy"] <= (1 + NEAR) * best["energy"],
        "over_trot": pick["energy"] / trot["energy"] if walked and trot is not None else None,
        "regret": pick["energy"] / best["energy"] - 1 if walked and best is not None else None,
        "kendall": _rank_correlation(all_walked),
        "kendall_of_own": _rank_correlation([row for row in all_walked if row["source"] != "hand-made"]),
        "crocoddyl": pick["crocoddyl"] / min(shots) if shots and pick["crocoddyl"] is not None else None,
    }


def _rank_correlation(rows: Sequence[Row]) -> float | None:
    """Kendall's tau of the model's cost and the energy, None for fewer than three."""
    told = [row for row in rows if row["model"] is not None]
    if len(told) < 3:
        return None
    tau = float(kendalltau([row["model"] for row in told], [row["energy"] for row in told])[0])
    return None if math.isnan(tau) else tau


def _by_task(rows: Sequence[Row]) -> list[list[Row]]:
    axes = ("speed", "cycle_duration")
    groups: dict[tuple[float, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(tuple(row[axis] for axis in axes), []).append(row)
    return list(groups.values())


def _best(rows: Sequence[Row]) -> Row | None:
    """The one of least energy among those that walked."""
    return min((row for row in rows if row["walked"]), key=lambda row: float(row["energy"]), default=None)


def _median(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return statistics.median(known) if known else None
