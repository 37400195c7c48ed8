"""The integrators: what they leave over on the exact motion falls with their order, and what is exact, is."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from rigid_motion import random_motion, simulated
from terms import constants, layout_of, node_of, numbers

from gaitflow.config.scenario import Scenario, Transcription
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.problem.dynamics import Body, body_of
from gaitflow.problem.step import RULES, base_defects

SLOPE = 15.0
SYMMETRIC = ("midpoint", "hermite_simpson", "momentum")


def body(scenario: Scenario) -> Body:
    return body_of(scenario.robot, constants(Task.of({"cycle_duration": 0.6, "slope": SLOPE})))


def left_over(scenario: Scenario, rule: str, h: float, seed: int, held: bool = False) -> Array:
    """The rule's defects [nb] of an exact step; feet stand, as those do that carry a force."""
    layout, robot = layout_of(scenario), scenario.robot
    x, forces, speeds = random_motion(layout, robot, seed)
    # The rate of change of a force is the same for any step, so that steps of all lengths are of one motion.
    ends = forces if held else forces + h / 0.1 * random_motion(layout, robot, seed + 100)[1]
    end = simulated(robot, SLOPE, x, forces, ends, 0 * speeds, h, h)
    return numbers(base_defects(rule, node_of(body(scenario), x, forces), node_of(body(scenario), end, ends), ca.SX(h)))


@pytest.mark.parametrize(("rule", "order"), [
    ("euler", 1), ("midpoint", 2), ("rk4", 4), ("hermite_simpson", 4), ("momentum", 4),
])  # fmt: skip
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_rule_leaves_over_what_its_order_says(either: Scenario, rule: str, order: int, seed: int) -> None:
    if rule == "momentum" and either.robot.dimension == 2:
        pytest.skip("exact there, see below")
    coarse, fine = (np.abs(left_over(either, rule, h, seed)).max() for h in (0.02, 0.01))
    assert coarse > 1e-10, "it is no exact rule for this body"
    assert np.log2(coarse / fine) == pytest.approx(order + 1, abs=0.6)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("h", [0.05, 0.3])
def test_momentum_is_exact_but_for_the_angles_in_space(either: Scenario, h: float, seed: int) -> None:
    """Position, velocity, angular momentum about the origin and a pitch, with linear forces and any step's length."""
    layout = layout_of(either)
    defects = left_over(either, "momentum", h, seed)
    turning = slice(layout.dimension, layout.dimension + (layout.angles if layout.dimension == 3 else 0))
    np.testing.assert_allclose(np.delete(defects, np.arange(layout.nb)[turning]), 0.0, atol=2e-8)


def test_runge_kutta_is_exact_in_the_plane_under_held_forces(planar: Scenario) -> None:
    """The motion is a polynomial of degree 4 there."""
    np.testing.assert_allclose(left_over(planar, "rk4", 0.1, 0, held=True), 0.0, atol=1e-9)


@pytest.mark.parametrize("rule", SYMMETRIC)
def test_a_symmetric_rule_run_backwards_is_itself(either: Scenario, rule: str) -> None:
    """Ends swapped and h negative: the same defects with the other sign, for any two ends."""
    layout, robot = layout_of(either), either.robot
    (x, f, _), (y, g, _) = (random_motion(layout, robot, seed) for seed in (0, 1))
    y[layout.nb :] = x[layout.nb :]  # feet stand
    first, last = node_of(body(either), x, f), node_of(body(either), y, g)
    forwards = numbers(base_defects(rule, first, last, ca.SX(0.1)))
    backwards = numbers(base_defects(rule, last, first, ca.SX(-0.1)))
    np.testing.assert_allclose(backwards, -forwards, rtol=1e-9, atol=1e-9)


def test_the_scenario_knows_which_rules_are_symmetric_in_time() -> None:
    assert {rule for rule in RULES if Transcription(integrator=rule).time_symmetric} == set(SYMMETRIC)
