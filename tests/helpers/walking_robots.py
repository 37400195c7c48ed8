"""Robots of published maps in MuJoCo, with a motion each, planned once."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from gaitflow.clients.description import describe
from gaitflow.clients.robot_model import RobotModel
from gaitflow.motion import Motion
from gaitflow.runtime import GaitMap

MODELS = Path(__file__).resolve().parents[2] / "models"


@cache
def planned(robot: str, speed: float, cycle_duration: float) -> Motion:
    """A motion of the base at a task of a robot's published map."""
    return GaitMap.load(MODELS / f"{robot}-exact-vibration").plan(speed, cycle_duration).motion(point="base")


def model(motion: Motion) -> RobotModel:
    """The robot of a motion, on the ground of its task."""
    return RobotModel.of(describe(motion.scenario), motion.scenario, motion.task)
