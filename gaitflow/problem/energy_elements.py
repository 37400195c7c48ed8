"""J4 as elements of the cost: each leg at each knot of a stance, each leg's swing, and the reaction of all swings."""

from __future__ import annotations

from collections import defaultdict

import casadi as ca
import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.layout import Layout
from gaitflow.problem.energy import JointCost
from gaitflow.problem.orientation import world_to_base
from gaitflow.problem.separable import Element
from gaitflow.problem.swing_reaction import SwingReaction
from gaitflow.problem.task import task_parameters


def energy_elements(scenario: Scenario, layout: Layout, scale: float) -> tuple[Element, ...]:
    """The joints' part of the cost over `scale`.

    Standing legs by the trapezoidal rule, a swing a leg, and where it has a weight what all swings do to the base.
    """
    joints = JointCost(scenario.robot, scenario.objective)
    legs = range(layout.legs)
    return (
        *(_standing(scenario, layout, joints, leg, scale) for leg in legs),
        *(_swing(scenario, layout, joints, leg, scale) for leg in legs),
        *([_reaction(scenario, layout, scale)] if scenario.objective.swing_reaction else []),
    )


def _standing(scenario: Scenario, layout: Layout, joints: JointCost, leg: int, scale: float) -> Element:
    """Of one leg: x is base state [12], foot [3], force [3] over the robot's weight, and the phase's fraction.

    A force of 0 costs nothing wherever the leg is, so phases in which it swings are left out of the derivatives.
    """
    shares: dict[tuple[int, int, int], float] = defaultdict(float)  # of knot, force and phase
    for step in range(layout.steps):
        phase = layout.phase_of(step)
        for knot, force in ((step, layout.force(step, leg)), (step + 1, layout.end_force(step, leg))):
            shares[knot, force.start, phase] += layout.shares[step % layout.knots_per_phase] / 2

    def beside_base(x: ca.SX, _: ca.SX) -> ca.SX:
        position, moving, foot, force, fraction = ca.vertsplit(x, [0, 3, 12, 15, 18, 19])
        return ca.vertcat(foot - position, moving, force * layout.weight, fraction)

    def in_base(x: ca.SX, parameters: ca.SX) -> ca.SX:
        offset, angles, velocity, omega, force, fraction = ca.vertsplit(x, [0, 3, 6, 9, 12, 15, 16])
        turn, cycle = world_to_base(angles), task_parameters(scenario.tasks, parameters)["cycle_duration"]
        return ca.vertcat(turn @ offset, turn @ velocity, omega, turn @ force, cycle * fraction)

    def passing(x: ca.SX, _: ca.SX) -> ca.SX:
        place, velocity, omega, rest = ca.vertsplit(x, [0, 3, 6, 9, 13])
        return ca.vertcat(place, -velocity - ca.cross(omega, place), rest)

    def of_joints(x: ca.SX, _: ca.SX) -> ca.SX:
        place, velocity, force, duration = ca.vertsplit(x, [0, 3, 6, 9, 10])
        return ca.vertcat(*joints.standing(leg, place, velocity, force), duration)

    def power(x: ca.SX, _: ca.SX) -> ca.SX:
        torques, rates, duration = ca.vertsplit(x, [0, 3, 6, 7])
        return duration * joints.per_second(torques, rates)

    places = [
        [
            *_range(layout.state(knot))[: layout.nb],
            *_range(layout.foot(knot, leg)),
            *range(force, force + layout.dimension),
            layout.fractions.start + phase,
        ]
        for knot, force, phase in shares
    ]
    gates = [layout.contacts(leg).start + phase for *_, phase in shares]
    maps = (beside_base, in_base, passing, of_joints, power)
    weights = np.array(list(shares.values())) / scale
    return Element.chained(maps, np.array(places), weights, np.array(gates))


def _swing(scenario: Scenario, layout: Layout, joints: JointCost, leg: int, scale: float) -> Element:
    """Of one leg: x is the phases' fractions, then in which of them it stands."""

    def cost(duration: ca.SX, parameters: ca.SX) -> ca.SX:
        return joints.swing(leg, task_parameters(scenario.tasks, parameters), duration, scenario.swing_clearance)

    def duration(x: ca.SX, parameters: ca.SX) -> ca.SX:
        fractions, contacts = ca.vertsplit(x, layout.phases)
        return task_parameters(scenario.tasks, parameters)["cycle_duration"] * ca.dot(fractions, 1 - contacts)

    places = np.array([[*_range(layout.fractions), *_range(layout.contacts(leg))]])
    return Element.chained((duration, cost), places, np.array([1 / scale]))


def _reaction(scenario: Scenario, layout: Layout, scale: float) -> Element:
    """Of all swings: x is the phases' fractions, then in which of them each leg stands."""
    reaction = SwingReaction(scenario.robot)

    def integral(x: ca.SX, parameters: ca.SX) -> ca.SX:
        task = task_parameters(scenario.tasks, parameters)
        fractions, *contacts = ca.vertsplit(x, layout.phases)
        return reaction.integral(task, task["cycle_duration"] * fractions, contacts)

    contacts = [place for leg in range(layout.legs) for place in _range(layout.contacts(leg))]
    places = np.array([[*_range(layout.fractions), *contacts]])
    return Element.chained((integral,), places, np.array([scenario.objective.swing_reaction / scale]))


def _range(places: slice) -> range:
    return range(places.start, places.stop)
