"""Single-rigid-body robots, as data."""

from gaitflow.robots.robot import Leg, Robot, load_robot

__all__ = ["Leg", "Robot", "load_robot"]
