"""J4 against numbers made by hand, the curve that swings follow, the check's own numpy, and on a solved motion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from terms import layout_of, with_axes

from gaitflow.config.scenario import Objective, Scenario, load_scenario
from gaitflow.core import check
from gaitflow.core.gaits import Pattern
from gaitflow.core.joints import Joints
from gaitflow.core.rigid_body import Attitude
from gaitflow.core.task import AXES, Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.motion.swing import swing
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.problem.energy import JointCost, positive
from gaitflow.problem.energy_elements import energy_elements
from gaitflow.problem.task import TaskParameters
from gaitflow.search import starts
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Start

TASK = Task.of({"speed": 0.6, "cycle_duration": 0.6})
WALK = Pattern.from_text("1110/1011/1011/1110")
HEAT, WORK = Objective(joint_heat=0.02), Objective(joint_work=1.0)
APEX = 0.04
Swings = dict[str, ca.Function]
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


def standing_power(scenario: Scenario, objective: Objective, x: Array, forces: Array) -> float:
    """What the problem's elements say of a state [24] and forces [4, 3] N: W."""
    changed = scenario.model_copy(update={"objective": objective})
    layout = layout_of(changed)
    total = 0.0
    for leg, element in enumerate(energy_elements(changed, layout, 1.0)[:4]):
        own = [x[:12], x[12 + 3 * leg : 15 + 3 * leg], forces[leg] / layout.weight, [1 / TASK.cycle_duration]]
        total += float(element.value(np.concatenate(own), TASK.parameters))
    return total


@pytest.mark.parametrize("seed", range(5))
def test_standing_legs_heat_is_that_of_their_torques(energy: Scenario, seed: int) -> None:
    """J^T f of every leg, squared; whatever way the base moves."""
    x, forces = posed(energy, seed)
    joints, attitude = joints_of(energy, HEAT), Attitude(x[3:6])
    feet, pushes = attitude.into_base(x[12:].reshape(4, 3) - x[:3]), attitude.into_base(forces)
    torques = [limb.jacobian(foot).T @ f for limb, foot, f in zip(joints.limbs, feet, pushes, strict=True)]
    assert standing_power(energy, HEAT, x, forces) == pytest.approx(0.02 * np.sum(np.square(torques)), rel=1e-9)


def test_standing_legs_work_is_what_lifts_the_body(energy: Scenario) -> None:
    """All joints' power adds up to force times velocity; p+ and (-p)+ of a joint differ by p."""
    x, forces = posed(energy, 0)
    x[9:12] = 0.0  # no turning
    backwards = x.copy()
    backwards[6:9] *= -1.0
    there, back = (standing_power(energy, WORK, each, forces) for each in (x, backwards))
    assert there - back == pytest.approx(forces.sum(axis=0) @ x[6:9], rel=1e-9)
    assert there > 0


def test_a_leg_without_a_force_costs_nothing_where_legs_stand(energy: Scenario) -> None:
    x, _ = posed(energy, 1)
    both = Objective(joint_heat=0.02, joint_work=1.0)
    assert standing_power(energy, both, x, np.zeros((4, 3))) == pytest.approx(0.0, abs=1e-12)


@pytest.fixture(scope="module")
def swings(energy: Scenario) -> Swings:
    """The problem's joules of each leg's swing [legs], by task [axes] and duration, as heat, work and both."""
    values, duration = ca.SX.sym("task", len(AXES)), ca.SX.sym("duration")
    task = TaskParameters(dict(zip(AXES, ca.vertsplit(values), strict=True)))
    found = {}
    for name, objective in {"heat": HEAT, "work": WORK, "both": energy.objective}.items():
        cost = JointCost(energy.robot, objective)
        each = ca.vertcat(*(cost.swing(leg, task, duration, APEX) for leg in range(4)))
        found[name] = ca.Function(name, [values, duration], [each])
    return found


def joules(swing: ca.Function, task: Task, duration: float) -> Array:
    """Of a swing of each leg [legs]."""
    return np.asarray(swing(task.parameters, duration)).ravel()


def along_the_curve(joints: Joints, leg: int, task: Task, duration: float) -> float:
    """A swing's joules along what is followed, sampled finely, against a body that moves as commanded."""
    x = (np.arange(2000) + 0.5) / 2000
    foot, limb = joints.default_feet[leg], joints.limbs[leg]
    body = complex(task["speed"], task["lateral_speed"]) + 1j * task["yaw_rate"] * complex(foot[0], foot[1])
    lifted, landed = np.zeros((len(x), 2), dtype=complex), np.zeros((len(x), 2), dtype=complex)
    landed[:, 0] = body * task.cycle_duration
    _, velocity, acceleration = swing(lifted, landed, np.full(len(x), duration), x, APEX)
    velocity = velocity - [body, 0.0]
    inverse = np.linalg.inv(limb.jacobian(foot))
    rates, pushed = (inverse @ [v[:, 0].real, v[:, 0].imag, v[:, 1].real] for v in (velocity, acceleration))
    torques = limb.inertia @ pushed
    power = torques * rates
    heat = joints.heat * np.square(torques).sum(axis=0).mean() * duration
    soft = (power + np.hypot(power, joints.smallest) - joints.smallest) / 2
    work = soft.sum(axis=0).mean() * duration + limb.mass * 9.81 * APEX / 2
    return float(heat + joints.work * work)


commands = st.builds(
    lambda speed, left, turn, cycle: Task.of(
        {"speed": speed, "lateral_speed": left, "yaw_rate": turn, "cycle_duration": cycle}
    ),
    st.floats(0.2, 1.4),
    st.floats(-0.4, 0.4),
    st.floats(-0.8, 0.8),
    st.floats(0.4, 0.9),
)
durations = st.floats(0.1, 0.6)


@given(task=commands, duration=durations)
def test_heat_of_swings_is_that_of_the_curve_that_is_followed(
    energy: Scenario, swings: Swings, task: Task, duration: float
) -> None:
    joints = joints_of(energy, HEAT)
    expected = [along_the_curve(joints, leg, task, duration) for leg in range(4)]
    assert joules(swings["heat"], task, duration) == pytest.approx(expected, rel=1e-6)
    assert joints.swings(task, np.full(4, duration), APEX) == pytest.approx(sum(expected), rel=1e-6)


@given(task=commands, duration=durations)
def test_work_of_swings_is_that_of_the_curve_that_is_followed(energy: Scenario, task: Task, duration: float) -> None:
    joints = joints_of(energy, WORK)
    expected = sum(along_the_curve(joints, leg, task, duration) for leg in range(4))
    assert joints.swings(task, np.full(4, duration), APEX) == pytest.approx(expected, rel=1e-3)


@given(task=commands, duration=durations)
def test_swings_cost_the_check_what_they_cost_the_problem(
    energy: Scenario, swings: Swings, task: Task, duration: float
) -> None:
    expected = joints_of(energy, energy.objective).swings(task, np.full(4, duration), APEX)
    assert joules(swings["both"], task, duration).sum() == pytest.approx(expected, rel=1e-3)


@given(task=commands, duration=durations)
def test_a_shorter_swing_is_dearer(swings: Swings, task: Task, duration: float) -> None:
    for name in ("heat", "work"):
        assert (joules(swings[name], task, 0.8 * duration) > joules(swings[name], task, duration)).all(), name


@given(task=commands, duration=durations)
def test_the_mirrored_leg_swings_the_mirrored_way_as_dear(
    energy: Scenario, swings: Swings, task: Task, duration: float
) -> None:
    image = joules(swings["both"], task.mirrored(), duration)[list(energy.robot.mirror_permutation)]
    assert image == pytest.approx(joules(swings["both"], task, duration), rel=1e-9)


def test_in_a_turn_outer_legs_swing_further(swings: Swings) -> None:
    """To the left, where the right one's way is a half longer."""
    left, right = joules(swings["heat"], TASK.replaced(yaw_rate=0.8), 0.2)[:2]
    assert left < 0.8 * right


def test_bounds_fix_the_contacts_of_a_pattern(problem: GaitProblem) -> None:
    bounds, layout = problem.bounds(WALK), problem.layout
    for leg, row in enumerate(WALK.rows):
        np.testing.assert_array_equal(bounds.lower[layout.contacts(leg)], [float(digit) for digit in row])
    contacts = slice(layout.fractions.stop, layout.nw)
    np.testing.assert_array_equal(bounds.upper[contacts], bounds.lower[contacts])


@pytest.mark.parametrize("text", ["1110/1011/1011", "11100/10111/10111/11100"])
def test_a_pattern_of_another_shape_is_refused(problem: GaitProblem, text: str) -> None:
    with pytest.raises(ValueError, match="the scenario has 4 and 4"):
        problem.bounds(Pattern.from_text(text))


def test_contacts_are_in_w_for_energy_only(energy: Scenario, problem: GaitProblem) -> None:
    other = energy.model_copy(update={"objective": Objective(force=1.0)})
    assert problem.layout.nw == layout_of(other).nw + 16 == problem.nlp.numel_in(0)


def packed(problem: GaitProblem, motion: Trajectory, pattern: Pattern) -> Array:
    """The scaled decision vector of a motion, with the contacts of a pattern."""
    layout = problem.layout
    w, contacts = layout.pack(motion, TASK.cycle_duration), slice(layout.fractions.stop, layout.nw)
    w[contacts] = problem.bounds(pattern).lower[contacts]
    return w


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
    pattern = Pattern.from_text("1110/1011/0011/1100")
    mirrored = Pattern.from_text("/".join(pattern.rows[leg] for leg in swap))
    one, other, astray = (
        float(problem.nlp(packed(problem, each, kept), when.parameters)[0])
        for each, kept, when in (
            (motion, pattern, task), (image, mirrored, task.mirrored()), (image, mirrored, task)
        )
    )  # fmt: skip
    assert other == pytest.approx(one, rel=1e-9)
    assert astray != pytest.approx(one, rel=1e-6) or not axes


def glide(problem: GaitProblem, task: Task) -> Trajectory:
    """Feet carried along with the body, on which no force acts."""
    layout = problem.layout
    motion = layout.unpack(starts.nominal(problem.scenario.robot, layout, task), task.cycle_duration)
    motion.forces[:] = motion.end_forces[:] = 0.0
    return motion


def both_costs(problem: GaitProblem, motion: Trajectory, task: Task) -> tuple[float, float]:
    """The program's and the check's, of WALK."""
    found = float(problem.nlp(packed(problem, motion, WALK), task.parameters)[0]) * problem.cost_scale
    return found, check.cost(problem.scenario.as_data(), motion, task, WALK.text)


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


@pytest.mark.parametrize("axes", [{}, {"yaw_rate": 0.7, "lateral_speed": -0.2}], ids=["straight", "turning"])
def test_legs_without_forces_cost_their_swings(energy: Scenario, axes: dict[str, float]) -> None:
    """Phases of 0.15 s: LF and RH swing in the last one, RF and LH in the second one."""
    scenario = with_axes(energy, **dict.fromkeys(axes, RANGE))
    problem = transcribe(scenario.model_copy(update={"objective": HEAT}))
    task, joints = TASK.replaced(**axes), joints_of(energy, HEAT)
    expected = sum(along_the_curve(joints, leg, task, 0.15) for leg in range(4))
    assert both_costs(problem, glide(problem, task), task) == pytest.approx((expected, expected), rel=1e-6)


def test_swings_last_as_long_as_all_their_phases(energy: Scenario) -> None:
    """Of two legs they go over the cycle's end, of the others they are its first and its last phase."""
    problem = transcribe(energy.model_copy(update={"objective": HEAT}))
    lasting, pattern = np.array([0.1, 0.2, 0.12, 0.18]), Pattern.from_text("0110/0111/1110/0110")
    motion = glide(problem, TASK)
    motion = replace(motion, durations=lasting, times=problem.layout.times(lasting))
    joints = joints_of(energy, HEAT)
    expected = sum(along_the_curve(joints, leg, TASK, each) for leg, each in enumerate((0.28, 0.1, 0.18, 0.28)))
    found = float(problem.nlp(packed(problem, motion, pattern), TASK.parameters)[0]) * problem.cost_scale
    assert found == pytest.approx(expected, rel=1e-6)
    assert check.cost(problem.scenario.as_data(), motion, TASK, pattern.text) == pytest.approx(expected, rel=1e-6)


def test_how_the_programs_own_feet_move_in_the_air_costs_nothing(problem: GaitProblem) -> None:
    motion = glide(problem, TASK)
    costs = both_costs(problem, motion, TASK)
    motion.foot_velocities[:] += np.random.default_rng(0).uniform(-1, 1, motion.foot_velocities.shape)
    motion.feet[:] += 0.01
    assert both_costs(problem, motion, TASK) == pytest.approx(costs, rel=1e-9)


def test_the_checks_cost_of_energy_needs_the_pattern(problem: GaitProblem) -> None:
    with pytest.raises(ValueError, match="the cost of an objective of energy needs the pattern as well"):
        check.cost(problem.scenario.as_data(), glide(problem, TASK), TASK)


def test_a_solved_motion_is_feasible_and_costs_what_the_check_finds(energy: Scenario, solved: Attempt) -> None:
    assert solved.feasible, solved.solver_status
    data = energy.as_data()
    found = check.violations(data, solved.trajectory, TASK, WALK.text)
    assert max(found.values()) <= check.FEASIBLE and "swing clearance" in found
    assert check.cost(data, solved.trajectory, TASK, WALK.text) == pytest.approx(solved.cost, rel=1e-2)


def test_solved_swings_clear_the_ground_in_their_middle(energy: Scenario, solved: Attempt) -> None:
    """Of 10 steps a phase: LF and RH swing in the last phase, RF and LH in the second one."""
    middles = solved.trajectory.feet[[35, 15, 15, 35], range(4), 2]
    assert middles.min() >= energy.swing_clearance - 1e-9
    free = transcribe(energy.model_copy(update={"swing_clearance": 0.0})).bounds(WALK)
    bound = transcribe(energy).bounds(WALK)
    assert np.flatnonzero(free.lower != bound.lower).size == 4
