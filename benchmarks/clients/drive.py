"""A drive of a minute from a stand to a top speed and back, by one map: falls, switches, and the loop's times."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Any

from benchmarks.document import document
from gaitflow.clients.description import describe
from gaitflow.clients.drive import Course, borders, drive
from gaitflow.clients.pilot import Pilot
from gaitflow.clients.robot_model import RobotModel
from gaitflow.runtime import GaitMap

TOP = 1.2  # m/s
NOTES = (
    "a tick is every 20 ms: the map is asked for a noisy speed, no cycle duration given; a change of motion is planned "
    "while the robot goes on for a second, its time is planning_s and not in tick_ms; late: it took longer than that",
    "control_ms: of a step of 2 ms, MuJoCo included; all in one process on one core",
    "borders: how often the gait without hysteresis changes along the course itself, without noise",
    "speed_error: rms of the mean speed over a second against the command; motions change by steps of 0.05 m/s",
)


def run(artifact: Path, tasks: int = 3, seed: int = 0) -> dict[str, Any]:
    """The document: a row a drive, each with noise of its own."""
    gait_map = GaitMap.load(artifact)
    scenario = gait_map.manifest.scenario
    description, rows = describe(scenario), []
    for number in range(tasks):
        course, pilot = Course(TOP, seed=seed + number), Pilot(gait_map)
        driven = drive(pilot, RobotModel.of(description, scenario, pilot.first.task), course)
        rows.append({"seed": course.seed, "borders": borders(pilot, course), **driven.as_data()})
    summary = {
        "drives": len(rows),
        "fell": sum(row["fell"] is not None for row in rows),
        "gait_changes": [row["gait_changes"] for row in rows],
        "borders": rows[0]["borders"],
        "tick_ms_p99": max(row["tick_ms"]["p99"] for row in rows),
        "control_ms_p99": max(row["control_ms"]["p99"] for row in rows),
        "planning_s_median": [row["planning_s"]["median"] for row in rows],
        "late": sum(row["late"] for row in rows),
        "speed_error": [row["speed_error"] for row in rows],
    }
    done = document("drive", gait_map.manifest.name, rows, summary, NOTES)
    done["versions"] |= {"mujoco": version("mujoco")}
    return done
