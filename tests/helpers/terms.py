"""Numbers into the problem's terms, and numbers out of them."""

from __future__ import annotations

import casadi as ca
import numpy as np

from gaitflow.config.scenario import Scenario, Tasks
from gaitflow.core.layout import Layout
from gaitflow.core.task import AXES, Task
from gaitflow.core.trajectory import Array
from gaitflow.problem.dynamics import Body, Node, node
from gaitflow.problem.task import TaskParameters


def numbers(expression: ca.SX) -> Array:
    """The values [n] of an expression without symbols."""
    return np.asarray(ca.DM(expression).full()).ravel()


def node_of(body: Body, x: Array, forces: Array) -> Node:
    """The node of a state [nx] and forces [legs, d] N."""
    legs, d = forces.shape
    nb = len(x) - legs * d
    feet = x[nb:].reshape(legs, d)
    return node(body, ca.SX(ca.DM(x[:nb])), [ca.SX(ca.DM(p)) for p in feet], [ca.SX(ca.DM(f)) for f in forces])


def constants(task: Task) -> TaskParameters:
    """A task's values as expressions, none of them left out."""
    return TaskParameters({axis: ca.SX(task[axis]) for axis in AXES})


def with_axes(scenario: Scenario, **axes: object) -> Scenario:
    """The scenario with other values or ranges on some axes."""
    data = scenario.tasks.as_data()
    return scenario.model_copy(update={"tasks": Tasks.from_data(data | {"axes": data["axes"] | axes}, "test")})


def layout_of(scenario: Scenario) -> Layout:
    return Layout.of(scenario.as_data())
