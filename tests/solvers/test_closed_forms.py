"""Motions whose optimum can be computed by hand, and symmetries that every optimum has."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from tasks_at import at

from gaitflow.config.scenario import Objective, Scenario, Transcription
from gaitflow.core.check import FEASIBLE, worst
from gaitflow.core.layout import GRAVITY
from gaitflow.core.trajectory import Trajectory
from gaitflow.problem import transcribe
from gaitflow.solvers.fixed_gait import Attempt

Solve = Callable[..., Attempt]
EFFORT = Objective(force=1.0)


def on(scenario: Scenario, **axes: float) -> Scenario:
    """The scenario with other fixed values of its tasks' axes."""
    tasks = scenario.tasks.model_copy(update={"axes": {**scenario.tasks.axes, **axes}})
    return scenario.model_copy(update={"tasks": tasks})


def test_standing_in_the_plane(effort: Scenario, solve: Solve) -> None:
    """Two legs carry half the weight each: J1 = T * 2 (m g / 2)^2."""
    weight = effort.robot.mass * GRAVITY
    attempt = solve(effort, "1111/1111", 0.0, 0.5)
    assert attempt.feasible
    assert attempt.cost == pytest.approx(0.5 * weight**2 / 2, rel=1e-6)
    np.testing.assert_allclose(attempt.trajectory.forces[..., 1], weight / 2, rtol=1e-4)
    np.testing.assert_allclose(attempt.trajectory.forces[..., 0], 0.0, atol=1e-3 * weight)


def test_standing_in_space(anymal: Scenario, solve: Solve) -> None:
    """Four legs carry a quarter each, though the front feet are 2 mm farther out: the base moves over their middle."""
    weight = anymal.robot.mass * GRAVITY
    attempt = solve(anymal.model_copy(update={"objective": EFFORT}), "1111/1111/1111/1111", 0.0, 0.8)
    assert attempt.feasible
    assert attempt.cost == pytest.approx(0.8 * weight**2 / 4, rel=1e-6)
    np.testing.assert_allclose(attempt.trajectory.forces[..., 2], weight / 4, rtol=1e-3)


def test_standing_on_a_slope_leans_until_the_legs_share_evenly(effort: Scenario, solve: Solve) -> None:
    """A box wide enough lets the body stand over the middle of its feet as gravity sees them; the cost is the same."""
    weight, slope = effort.robot.mass * GRAVITY, np.radians(20.0)
    attempt = solve(on(effort, slope=20.0), "1111/1111", 0.0, 0.5, slope=20.0)
    assert attempt.feasible
    assert attempt.cost == pytest.approx(0.5 * weight**2 / 2, rel=1e-6)
    shares = np.broadcast_to([np.sin(slope), np.cos(slope)], (40, 2, 2)) * weight / 2
    np.testing.assert_allclose(attempt.trajectory.forces, shares, atol=1e-3 * weight)
    lever = attempt.trajectory.feet[:-1].mean(axis=1) - attempt.trajectory.base[:-1, :2]
    np.testing.assert_allclose(lever[:, 0] / lever[:, 1], np.tan(slope), atol=1e-3)


def test_standing_on_a_slope_in_a_tight_box_loads_the_hind_leg(effort: Scenario, solve: Solve) -> None:
    """With the posture given, forces are the least squares solution of the balances of force and moment."""
    robot = effort.robot.model_copy(update={"box": (1e-4, 1e-4)})
    scenario = on(effort.model_copy(update={"robot": robot}), slope=20.0)
    attempt = solve(scenario, "1111/1111", 0.0, 0.5, slope=20.0, friction=2.0)
    assert attempt.feasible
    weight, slope = robot.mass * GRAVITY, np.radians(20.0)
    # Unknown: front x, z, hind x, z. Levers of the default posture: (0.5, -0.5) and (-0.5, -0.5).
    balance = np.array([[1, 0, 1, 0], [0, 1, 0, 1], [0.5, 0.5, 0.5, -0.5]])
    forces = np.linalg.pinv(balance) @ [weight * np.sin(slope), weight * np.cos(slope), 0.0]
    assert forces[3] > 2 * forces[1]  # the hind leg carries most
    assert attempt.cost == pytest.approx(0.5 * forces @ forces, rel=2e-3)
    np.testing.assert_allclose(attempt.trajectory.forces.reshape(40, 4).mean(axis=0), forces, atol=5e-3 * weight)


def test_nobody_stands_on_a_slope_steeper_than_friction_allows(effort: Scenario, solve: Solve) -> None:
    """tan(20 degrees) = 0.364."""
    scenario = on(effort, slope=20.0)
    assert solve(scenario, "1111/1111", 0.0, 0.5, slope=20.0, friction=0.38).feasible
    attempt = solve(scenario, "1111/1111", 0.0, 0.5, slope=20.0, friction=0.35)
    assert not attempt.feasible
    assert attempt.violation > 1e-3


def test_hopping_on_the_spot_follows_the_ballistic_law(effort: Scenario, solve: Solve) -> None:
    """One stance and one flight: the longest stance, 0.9 T, is best; a constant force carries m g T over it.

    J1 = 2 legs * (m g T / (2 * 0.9 T))^2 * 0.9 T. Speeds follow from Euler's sums: v falls by g h a step in flight,
    and the heights add up to zero over the cycle.
    """
    n, cycle = 10, 0.5
    scenario = effort.model_copy(update={"transcription": Transcription(phases=2, knots_per_phase=n)})
    attempt = solve(scenario, "10/10", 0.0, cycle)
    assert attempt.feasible
    weight = effort.robot.mass * GRAVITY
    stance, flight = 0.9 * cycle, 0.1 * cycle
    np.testing.assert_allclose(attempt.trajectory.durations, [stance, flight], rtol=1e-6)
    assert attempt.cost == pytest.approx((weight * cycle) ** 2 / (2 * stance), rel=1e-6)
    steps = np.repeat([stance / n, flight / n], n)
    gain = np.repeat([GRAVITY * (cycle / stance - 1), -GRAVITY], n) * steps
    speeds = np.append(0.0, np.cumsum(gain))
    speeds -= (steps @ speeds[:-1]) / cycle
    np.testing.assert_allclose(attempt.trajectory.base[:, 4], speeds, atol=1e-4)


@pytest.mark.parametrize(("pattern", "speed", "cycle"), [("0110/1100", 0.9, 0.6), ("0001/0100", 1.5, 1.0)])
def test_where_the_cycle_is_cut_changes_no_cost(
    effort: Scenario, solve: Solve, pattern: str, speed: float, cycle: float
) -> None:
    rows = pattern.split("/")
    costs = []
    for cut in range(4):
        attempt = solve(effort, "/".join(row[cut:] + row[:cut] for row in rows), speed, cycle)
        assert attempt.feasible
        costs.append(attempt.cost)
    assert costs == pytest.approx([costs[0]] * 4, rel=1e-6)


WALK, MIRRORED, CUT = "0111/1101/1110/1011", "1101/0111/1011/1110", "1110/1011/1101/0111"  # legs LF, RF, LH, RH


def test_the_mirror_image_of_a_motion_in_space(anymal: Scenario, solve: Solve) -> None:
    """y, yaw and roll change sign and legs swap: the optimum itself mirrors, and with it the cost."""
    one, other = solve(anymal, WALK, 0.3, 0.8), solve(anymal, MIRRORED, 0.3, 0.8)
    assert one.feasible and other.feasible
    assert one.cost == pytest.approx(other.cost, rel=1e-6)
    signs = [1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1]  # x y z, yaw pitch roll, velocities, omega x y z
    np.testing.assert_allclose(one.trajectory.base * signs, other.trajectory.base, atol=1e-4)
    swapped = one.trajectory.forces[:, [1, 0, 3, 2]] * [1, -1, 1]
    np.testing.assert_allclose(swapped, other.trajectory.forces, atol=1.0)


def test_a_motion_cut_elsewhere_is_a_motion_of_the_same_cost(anymal: Scenario, solve: Solve) -> None:
    """The first phase moved to the end, v T ahead. Two solves may end in two minima; one motion has one cost."""
    speed, cycle, n = 0.3, 0.8, anymal.transcription.knots_per_phase
    found = solve(anymal, WALK, speed, cycle)
    assert found.feasible
    old = found.trajectory
    base = np.vstack([old.base[n:-1], old.base[: n + 1]])
    feet = np.concatenate([old.feet[n:-1], old.feet[: n + 1]])
    base[-n - 1 :, 0] += speed * cycle
    feet[-n - 1 :, :, 0] += speed * cycle
    start = base[0, 0]
    base[:, 0] -= start
    feet[..., 0] -= start
    durations = np.roll(old.durations, -1)
    cut = Trajectory(
        times=transcribe(anymal).layout.times(durations),
        base=base,
        feet=feet,
        forces=np.roll(old.forces, -n, axis=0),
        end_forces=np.roll(old.end_forces, -n, axis=0),
        foot_velocities=np.roll(old.foot_velocities, -n, axis=0),
        durations=durations,
    )
    task = at(speed, cycle)
    assert worst(anymal.as_data(), cut, task, CUT) <= FEASIBLE
    problem = transcribe(anymal)
    cost = float(problem.nlp(problem.layout.pack(cut, cycle), task.parameters)[0]) * problem.cost_scale
    assert cost == pytest.approx(found.cost, rel=1e-9)
