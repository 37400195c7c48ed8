"""Whole-body shooting and predictive control from a map's plans, from a hand-made trot, and cold."""

from __future__ import annotations

import statistics
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from benchmarks.clients.tasks import random_plans
from benchmarks.document import document
from gaitflow.clients.default_gaits import default_motion
from gaitflow.clients.description import describe
from gaitflow.clients.predictive import Prediction, Predictor
from gaitflow.clients.shooting import Shot, Start, shoot
from gaitflow.clients.whole_body import WholeBody, load_whole_body
from gaitflow.motion import Motion
from gaitflow.runtime import GaitMap, Plan

DUTY = 0.5  # of the hand-made trot
CYCLES = 2  # of the shooting problem
NOTES = (
    "crocoddyl: FDDP on the whole body over two cycles, steps of 0.02 s; from a motion it starts at its inverse "
    "kinematics and torques, cold in the first state all along with the torques that hold it still",
    "fatrop: a single rigid body over one cycle of 24 intervals; cold in the first state all along, the weight shared",
    "plan's swings: the feet of the plan itself, which stay in the map's kinematic box, straight from knot to knot; "
    "plan: the smooth swings of Plan.motion; fatrop, to which swings do not matter, has the same problem twice",
    "plan and trot are two problems, each with its own contacts, of the same weights of the command and of torques or "
    "forces; cold is the same problem as the line before it, so its cost should be the same",
    "out_of_reach_m: how far a foot of the motion is beyond what its leg reaches; such a problem has no good start",
    "seconds of a call, without building the problem of fatrop and without the start of Crocoddyl",
)


def run(artifact: Path, tasks: int = 8, seed: int = 0) -> dict[str, Any]:
    """The document: a row a task and start. Raises ConfigError where the robot's description is not installed."""
    gait_map = GaitMap.load(artifact)
    scenario = gait_map.manifest.scenario
    body, predictor = load_whole_body(describe(scenario).urdf.path, scenario), Predictor(scenario)
    rows = [row for plan in random_plans(gait_map, tasks, seed) for row in _rows(plan, body, predictor)]
    methods = dict.fromkeys(row["start"] for row in rows)
    summary = {method: _summary([row for row in rows if row["start"] == method]) for method in methods}
    done = document("clients", gait_map.manifest.name, rows, summary, NOTES)
    done["versions"] |= {name: version(name) for name in ("crocoddyl", "pin")}
    return done


def _rows(plan: Plan, body: WholeBody, predictor: Predictor) -> Iterator[dict[str, Any]]:
    planned, own_swings = plan.motion(), plan.motion(swing_apex=None)
    trot = default_motion(plan.scenario, "trot", planned.task, DUTY)
    cases: list[tuple[str, Motion, Start]] = [
        ("plan", planned, "motion"),
        ("plan, cold", planned, "cold"),
        ("plan's swings", own_swings, "motion"),
        ("plan's swings, cold", own_swings, "cold"),
        ("trot", trot, "motion"),
        ("trot, cold", trot, "cold"),
    ]
    for name, motion, start in cases:
        shot, prediction = shoot(body, motion, CYCLES, start=start), predictor.predict(motion, start=start)
        yield {
            **plan.task,
            "start": name,
            "gait": f"trot of duty {DUTY:g}" if motion is trot else plan.gait,
            "out_of_reach_m": float(body.along(motion, shot.times).missed.max()),
            "crocoddyl": _answer(shot) | {"feet_error_m": shot.feet_error},
            "fatrop": _answer(prediction),
        }


def _answer(found: Shot | Prediction) -> dict[str, Any]:
    return {key: getattr(found, key) for key in ("iterations", "cost", "ready", "seconds")}


def _summary(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    return {"tasks": len(rows)} | {
        solver: {
            "ready": sum(row[solver]["ready"] for row in rows),
            "iterations": [row[solver]["iterations"] for row in rows],
            "iterations_median": statistics.median(row[solver]["iterations"] for row in rows),
            "cost_median": statistics.median(row[solver]["cost"] for row in rows),
            "seconds_median": statistics.median(row[solver]["seconds"] for row in rows),
        }
        for solver in ("crocoddyl", "fatrop")
    }
