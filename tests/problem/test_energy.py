"""J4 against numbers made by hand, against the check's own numpy, and on a solved motion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from terms import node_of, numbers, with_axes

from gaitflow.config.scenario import Objective, Scenario, load_scenario
from gaitflow.core import check
from gaitflow.core.gaits import Pattern
from gaitflow.core.joints import Joints
from gaitflow.core.rigid_body import Attitude
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.problem.dynamics import Body
from gaitflow.problem.energy import SHARPER, SMOOTH_POWER, JointCost, knot_motion, positive
from gaitflow.search import starts
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Start

TASK = Task.of({"speed": 0.6, "cycle_duration": 0.6})
WALK = Pattern.from_text("1110/1011/1011/1110")
HEAT, WORK = Objective(joint_heat=0.02), Objective(joint_work=1.0)
RANGE = {"start": -1.0, "stop": 1.0, "count": 2}


@pytest.fixture(scope="module")
def energy(checkout: Path) -> Scenario:
    """ANYmal, J4."""
    return load_scenario(checkout / "configs/scenarios/anymal-energy.yaml")


@pytest.fixture(scope="module")
def problem(energy: Scenario) -> GaitProblem:
    return transcribe(energy)


@pytest.fixture(scope="module")
def solved(problem: GaitProblem) -> Attempt:
    start = Start("nominal", starts.nominal(problem.scenario.robot, problem.layout, TASK))
    return FixedGaitSolver(problem, 20.0).solve(WALK, TASK, start)


def column(*values: float) -> ca.SX:
    return ca.SX(ca.DM(list(values)))


lengths = st.lists(st.floats(1e-3, 1.0), min_size=3, max_size=8)


def moved(steps: Array, path: list[float]) -> tuple[Array, list[ca.SX], list[ca.SX]]:
    """Knots of steps [K] s, and velocities along the polynomial `path`, highest power first, as a step has them."""
    times = np.append(0.0, np.cumsum(steps))
    return times, [column(v) for v in np.diff(np.polyval(path, times)) / steps], [column(h) for h in steps]


@given(lengths, st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_knots_of_a_steady_acceleration_are_exact(steps: list[float], push: float, speed: float) -> None:
    times, velocities, h = moved(np.array(steps), [push / 2, speed, 0.0])
    found = knot_motion(velocities, h)
    for time, (velocity, acceleration) in list(zip(times, found, strict=True))[1:-1]:
        assert numbers(velocity) == pytest.approx(speed + push * time, abs=1e-9)
        assert numbers(acceleration) == pytest.approx(push, abs=1e-8)


@given(st.floats(0.01, 1.0), st.floats(-5.0, 5.0))
def test_knots_of_a_cubic_in_even_steps(h: float, jerk: float) -> None:
    """Acceleration is exact, velocity is off by jerk h^2 / 6: the means of two chords."""
    times, velocities, steps = moved(np.full(6, h), [jerk / 6, 0.3, -0.2, 0.0])
    for time, (velocity, acceleration) in list(zip(times, knot_motion(velocities, steps), strict=True))[1:-1]:
        exact = np.polyval([jerk / 2, 0.6, -0.2], time)
        assert numbers(velocity) == pytest.approx(exact + jerk * h**2 / 6, abs=1e-9)
        assert numbers(acceleration) == pytest.approx(jerk * time + 0.6, abs=1e-8)


@given(lengths, st.integers(0, 7))
def test_a_cycle_may_be_cut_anywhere(steps: list[float], cut: int) -> None:
    speeds, cut = np.sin(np.arange(len(steps)) ** 2), cut % len(steps)
    found = knot_motion([column(v) for v in speeds], [column(h) for h in steps])
    turned = knot_motion([column(v) for v in np.roll(speeds, -cut)], [column(h) for h in np.roll(steps, -cut)])
    assert len(found) == len(steps) + 1
    for k, knot in enumerate(turned):
        np.testing.assert_allclose(numbers(ca.vertcat(*knot)), numbers(ca.vertcat(*found[(cut + k) % len(steps)])))


def test_a_motion_that_is_no_cycle_ends_as_it_moves() -> None:
    speeds, h = [column(v) for v in (1.0, 2.0, 4.0)], [column(0.1)] * 3
    cycle, open_ended = knot_motion(speeds, h), knot_motion(speeds, h, closed=False)
    assert [float(velocity) for velocity, _ in open_ended] == pytest.approx([1.0, 1.5, 3.0, 4.0])
    assert [float(push) for _, push in open_ended] == pytest.approx([0.0, 10.0, 20.0, 0.0])
    assert float(cycle[0][0]) == float(cycle[-1][0]) == pytest.approx(2.5)
    assert float(cycle[0][1]) == float(cycle[-1][1]) == pytest.approx(-30.0)


powers = st.floats(-1e4, 1e4)


@given(powers, powers, st.floats(0.1, 10.0))
def test_positive_power(one: float, other: float, width: float) -> None:
    """Rising, 0 at 0, at most half a width below max(0, p), and its mirror image differs by p itself."""
    found, image, beside = (float(positive(ca.SX(p), width)) for p in (one, -one, other))
    assert float(positive(ca.SX(0.0), width)) == 0.0
    assert max(0.0, one) - width / 2 - 1e-9 <= found <= max(0.0, one) + 1e-9
    assert found - image == pytest.approx(one, abs=1e-8)
    assert (found - beside) * (one - other) >= 0


def posed(scenario: Scenario, seed: int) -> tuple[Array, Array]:
    """A state [24] near standing, anywhere and turned anyhow, and forces [4, 3] N."""
    rng = np.random.default_rng(seed)
    default = np.array([leg.default_foot for leg in scenario.robot.legs])
    place, angles = rng.uniform(-1, 1, 3), np.array([2.0, 0.2, -0.2]) * rng.uniform(-1, 1, 3)
    feet = default + rng.uniform(-1, 1, (4, 3)) * scenario.robot.box
    to_world = np.linalg.inv(Attitude(angles).into_base(np.eye(3)).T)
    motion = rng.uniform(-1, 1, 6)
    return np.concatenate([place, angles, motion, (place + feet @ to_world.T).ravel()]), rng.uniform(-200, 200, (4, 3))


def joints_of(scenario: Scenario, objective: Objective) -> Joints:
    found = Joints.of(scenario.model_copy(update={"objective": objective}).as_data())
    assert found is not None
    return found


def body_at_rest() -> Body:
    return Body(ca.SX(30.0), ca.DM.eye(3), column(0.0, 0.0, -9.81))


@pytest.mark.parametrize("seed", range(5))
def test_standing_legs_heat_is_that_of_their_torques(energy: Scenario, seed: int) -> None:
    """J^T f of every leg, squared; whatever way the base moves."""
    x, forces = posed(energy, seed)
    joints, attitude = joints_of(energy, HEAT), Attitude(x[3:6])
    feet, pushes = attitude.into_base(x[12:].reshape(4, 3) - x[:3]), attitude.into_base(forces)
    torques = [limb.jacobian(foot).T @ f for limb, foot, f in zip(joints.limbs, feet, pushes, strict=True)]
    found = JointCost(energy.robot, HEAT).standing(node_of(body_at_rest(), x, forces))
    assert float(ca.DM(found)) == pytest.approx(0.02 * np.sum(np.square(torques)), rel=1e-9)


def test_standing_legs_work_is_what_lifts_the_body(energy: Scenario) -> None:
    """All joints' power adds up to force times velocity; p+ and (-p)+ of a joint differ by p."""
    x, forces = posed(energy, 0)
    x[9:12] = 0.0  # no turning
    backwards = x.copy()
    backwards[6:9] *= -1.0
    cost = JointCost(energy.robot, WORK)
    there, back = (float(ca.DM(cost.standing(node_of(body_at_rest(), each, forces)))) for each in (x, backwards))
    assert there - back == pytest.approx(forces.sum(axis=0) @ x[6:9], rel=1e-9)
    assert there > 0


def test_a_leg_without_a_force_costs_nothing_where_legs_stand(energy: Scenario) -> None:
    x, _ = posed(energy, 1)
    both = JointCost(energy.robot, Objective(joint_heat=0.02, joint_work=1.0))
    assert float(ca.DM(both.standing(node_of(body_at_rest(), x, np.zeros((4, 3)))))) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("leg", range(4))
def test_a_swing_by_hand(energy: Scenario, leg: int) -> None:
    """A push that grows from nothing: a third of the last one's heat; at a steady speed its power, at three times."""
    rng = np.random.default_rng(leg)
    push, velocity = rng.uniform(-20, 20, 3), rng.uniform(-2, 2, 3)
    joints = joints_of(energy, HEAT)
    inverse = np.linalg.inv(joints.limbs[leg].jacobian(joints.default_feet[leg]))
    torques, rates = SHARPER * joints.limbs[leg].inertia @ inverse @ push, inverse @ velocity
    ends = (column(*velocity), column(0, 0, 0)), (column(*velocity), column(*push))
    heat = float(ca.DM(JointCost(energy.robot, HEAT).swinging(leg, *ends)))
    assert heat == pytest.approx(0.02 * torques @ torques / 3, rel=1e-9)
    width = SMOOTH_POWER * energy.robot.mass
    watts = [np.sum(part * torques * rates + np.hypot(part * torques * rates, width) - width) / 2 for part in (0.5, 1)]
    work = float(ca.DM(JointCost(energy.robot, WORK).swinging(leg, *ends)))
    assert work == pytest.approx((4 * watts[0] + watts[1]) / 6, rel=1e-9)


@pytest.mark.parametrize("axes", [{}, {"yaw_rate": 0.7, "lateral_speed": 0.2}], ids=["straight", "turning"])
def test_mirror_images_cost_the_same(energy: Scenario, axes: dict[str, float]) -> None:
    task = TASK.replaced(**axes)
    problem = transcribe(with_axes(energy, **dict.fromkeys(axes, RANGE)))
    layout, robot = problem.layout, problem.scenario.robot
    w = starts.random(robot, layout, task, np.random.default_rng(0))
    motion, swap, flip = layout.unpack(w, 0.6), list(robot.mirror_permutation), np.array([1.0, -1.0, 1.0])
    image = replace(
        motion,
        base=motion.base * np.concatenate([flip, -flip * [1, 1, 1], flip, -flip]),
        **{name: getattr(motion, name)[:, swap] * flip for name in ("feet", "forces", "end_forces", "foot_velocities")},
    )
    image.base[:, 3:6] = motion.base[:, 3:6] * [-1.0, 1.0, -1.0]
    one, other = (
        float(problem.nlp(layout.pack(each, 0.6), when.parameters)[0])
        for each, when in ((motion, task), (image, task.mirrored()))
    )
    assert other == pytest.approx(one, rel=1e-9)
    assert float(problem.nlp(layout.pack(image, 0.6), task.parameters)[0]) != pytest.approx(one, rel=1e-6) or not axes


def glide(problem: GaitProblem, task: Task) -> Trajectory:
    """Feet carried along with the body, on which no force acts."""
    layout = problem.layout
    motion = layout.unpack(starts.nominal(problem.scenario.robot, layout, task), task.cycle_duration)
    motion.forces[:] = motion.end_forces[:] = 0.0
    return motion


def both_costs(problem: GaitProblem, motion: Trajectory, task: Task) -> tuple[float, float]:
    """The program's and the check's."""
    w = problem.layout.pack(motion, task.cycle_duration)
    found = float(problem.nlp(w, task.parameters)[0]) * problem.cost_scale
    return found, check.cost(problem.scenario.as_data(), motion, task)


def test_held_forces_count_over_their_own_step(energy: Scenario) -> None:
    """While legs squeeze the ground the body stays, so a step's heat is constant: the trapezoidal rule is exact."""
    held = energy.transcription.model_copy(update={"forces": "held"})
    problem = transcribe(energy.model_copy(update={"transcription": held, "objective": HEAT}))
    motion = glide(problem, TASK)
    motion.forces[..., 2] = problem.layout.weight / 4
    squeeze = np.random.default_rng(0).uniform(0, 200, (problem.layout.steps, 1))
    motion.forces[..., 1] = squeeze * [1.0, -1.0, 1.0, -1.0]
    found, expected = both_costs(problem, replace(motion, end_forces=motion.forces.copy()), TASK)
    assert found == pytest.approx(expected, rel=1e-3)


def test_a_hop_costs_in_a_turn_what_it_costs_straight_on(energy: Scenario) -> None:
    """A foot that goes up and down on the spot of a body that turns: against what is beside it, not the centre."""
    problem = transcribe(with_axes(energy, yaw_rate=RANGE).model_copy(update={"objective": WORK}))
    costs = []
    for task in (TASK, TASK.replaced(yaw_rate=0.8)):
        motion = glide(problem, task)
        motion.foot_velocities[..., 2] = np.sin(2 * np.pi * motion.times[1:] / task.cycle_duration)[:, None]
        costs += both_costs(problem, motion, task)
    assert costs[0] > 0.1
    assert costs == pytest.approx([costs[0]] * 4, rel=1e-3)


def test_a_solved_motion_is_feasible_and_costs_what_the_check_finds(energy: Scenario, solved: Attempt) -> None:
    assert solved.feasible, solved.solver_status
    data = energy.as_data()
    found = check.violations(data, solved.trajectory, TASK, WALK.text)
    assert max(found.values()) <= check.FEASIBLE and "swing clearance" in found
    assert check.cost(data, solved.trajectory, TASK) == pytest.approx(solved.cost, rel=1e-2)


def test_solved_swings_clear_the_ground_in_their_middle(energy: Scenario, solved: Attempt) -> None:
    """Of 10 steps a phase: LF and RH swing in the last phase, RF and LH in the second one."""
    middles = solved.trajectory.feet[[35, 15, 15, 35], range(4), 2]
    assert middles.min() >= energy.swing_clearance - 1e-9
    free = transcribe(energy.model_copy(update={"swing_clearance": 0.0})).bounds(WALK)
    bound = transcribe(energy).bounds(WALK)
    assert np.flatnonzero(free.lower != bound.lower).size == 4
