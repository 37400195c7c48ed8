"""The legs' reach in swings: rows against the curve that is followed, which rows a pattern has, and a long stride."""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from terms import node_of

from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.core import check, swing_reach
from gaitflow.core.gaits import Pattern
from gaitflow.core.joints import Limb
from gaitflow.core.rigid_body import Attitude
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.motion import Motion
from gaitflow.motion.swing import swing
from gaitflow.problem import GaitProblem, reach, transcribe
from gaitflow.problem.dynamics import Body
from gaitflow.search import starts
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Start

LONG = Task.of({"speed": 1.2, "cycle_duration": 0.7})
BOUNCING = Pattern.from_text("0001/0100/0100/0001")
APEX = 0.04


@pytest.fixture(scope="module")
def walking(checkout: Path) -> Scenario:
    """ANYmal, J4."""
    return load_scenario(checkout / "configs/scenarios/anymal-energy.yaml")


@pytest.fixture(scope="module")
def problem(walking: Scenario) -> GaitProblem:
    return transcribe(walking)


@pytest.fixture(scope="module")
def solved(problem: GaitProblem) -> Attempt:
    start = Start("nominal", starts.nominal(problem.scenario.robot, problem.layout, LONG))
    return FixedGaitSolver(problem, 20.0).solve(BOUNCING, LONG, start)


def lengths(limb: Limb, places: Array, angles: Array) -> Array:
    """Of a leg, over thigh and shank, with its foot at places [n, 3] m against the body."""
    return limb.length(Attitude(np.broadcast_to(angles, places.shape)).into_base(places))


@pytest.mark.parametrize("side", [1, -1], ids=["lift-off", "touchdown"])
def test_rows_are_the_curve_against_a_body_that_goes_on(walking: Scenario, side: int) -> None:
    rng, robot = np.random.default_rng(0), walking.robot
    default = np.array([leg.default_foot for leg in robot.legs])
    x = np.concatenate([rng.uniform(-0.1, 0.1, 12), (default + rng.uniform(-0.1, 0.1, (4, 3))).ravel()])
    way, duration, parts = np.array([0.6, 0.1, 0.0]), 0.3, np.array(reach.PARTS)
    body = Body(ca.SX(30.0), ca.DM.eye(3), ca.SX(ca.DM([0.0, 0.0, -9.81])))
    node = node_of(body, x, np.zeros((4, 3)))
    for leg, limb in enumerate(robot.limbs or ()):
        rows = reach.reach_rows(limb, node, node.feet[leg], ca.SX(ca.DM(way)), ca.SX(duration), ca.SX(side), APEX)
        foot = x[12:].reshape(4, 3)[leg]
        lifted, landed = (foot, foot + way) if side == 1 else (foot - way, foot)
        at = parts if side == 1 else 1 - parts
        pairs = [np.tile([complex(*place[:2]), complex(place[2])], (len(at), 1)) for place in (lifted, landed)]
        curve, _, _ = swing(*pairs, np.full(len(at), duration), at, APEX)
        feet = np.stack([curve[:, 0].real, curve[:, 0].imag, curve[:, 1].real], axis=-1)
        passed = side * np.outer(parts * duration, x[6:9])
        expected = lengths(Limb.of(limb.model_dump()), feet - x[:3] - passed, x[3:6])
        np.testing.assert_allclose(np.array(ca.DM(rows)).ravel(), expected / reach.STRETCH - 1, atol=1e-12)


def test_only_where_swings_begin_and_end_does_a_row_ask(walking: Scenario, problem: GaitProblem) -> None:
    bounds = problem.bounds(BOUNCING)
    rows = 4 * 4 * len(reach.PARTS)
    asked = slice(problem.ng - 1 - problem.layout.nx - rows, problem.ng - 1 - problem.layout.nx)
    finite = np.isfinite(bounds.upper_rows[asked]).reshape(4, 4, -1).all(axis=-1)
    stands = np.array([[digit == "1" for digit in row] for row in BOUNCING.rows])
    np.testing.assert_array_equal(finite, stands != np.roll(stands, -1, axis=1))
    assert not np.isfinite(bounds.lower_rows[asked]).any()
    assert transcribe(walking.model_copy(update={"swing_clearance": 0.0})).ng == problem.ng - rows


def test_on_a_long_stride_no_leg_is_straight_in_the_swing_that_is_followed(walking: Scenario, solved: Attempt) -> None:
    assert solved.feasible and solved.trajectory is not None
    data = walking.as_data()
    motion = Motion.of(data, solved.trajectory, LONG, BOUNCING.text, APEX, "com")
    seen = motion.sample(np.linspace(0.0, motion.period, 300, endpoint=False))
    rotated = seen.feet - seen.position[:, None]
    w, x, y, z = np.moveaxis(seen.orientation, -1, 0)
    across = np.stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)], axis=-1)
    forward = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=-1)
    axes = np.stack([forward, across, np.cross(forward, across)], axis=-2)
    for leg, limb in enumerate(data["robot"]["limbs"]):
        places = np.einsum("nij,nj->ni", axes, rotated[:, leg])
        assert Limb.of(limb).length(places).max() < 0.97


def raised(trajectory: Trajectory, height: float) -> Trajectory:
    base = trajectory.base.copy()
    base[:, 2] += height
    return Trajectory(**{**vars(trajectory), "base": base})


def test_the_check_sees_legs_that_are_too_short(walking: Scenario, solved: Attempt) -> None:
    assert solved.trajectory is not None
    data = walking.as_data()
    assert check.violations(data, solved.trajectory, LONG, BOUNCING.text)["swing reach"] <= check.FEASIBLE
    high = check.violations(data, raised(solved.trajectory, 0.08), LONG, BOUNCING.text)
    assert 0.01 < high["swing reach"] < 0.3
    assert "swing reach" not in check.violations(
        data | {"swing_clearance": 0.0}, solved.trajectory, LONG, BOUNCING.text
    )


@pytest.mark.parametrize("height", [0.0, 0.05, 0.1])
def test_the_check_asks_what_the_rows_ask(
    walking: Scenario, problem: GaitProblem, solved: Attempt, height: float
) -> None:
    assert solved.trajectory is not None
    moved = raised(solved.trajectory, height)
    bounds = problem.bounds(BOUNCING)
    w = problem.layout.pack(moved, LONG.cycle_duration, BOUNCING.text)
    contacts = slice(problem.layout.fractions.stop, problem.layout.nw)
    np.testing.assert_array_equal(w[contacts], bounds.lower[contacts])
    rows = np.array(problem.nlp(w, LONG.parameters)[1]).ravel()
    size, end = 4 * 4 * len(reach.PARTS), problem.ng - 1 - problem.layout.nx
    asked = np.isfinite(bounds.upper_rows[end - size : end])
    worst = max(0.0, rows[end - size : end][asked].max())
    found = check.violations(walking.as_data(), moved, LONG, BOUNCING.text)["swing reach"]
    assert found == pytest.approx(worst, abs=1e-9)


def test_the_constants_are_the_checks() -> None:
    assert reach.STRETCH == swing_reach.LONGEST
    assert tuple(swing_reach.PARTS) == reach.PARTS
