"""What a task means, by solving: a glide along the command costs nothing, and images of a task are its equals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from terms import with_axes

from gaitflow.config.scenario import Objective, Scenario, Transcription, load_scenario
from gaitflow.core import check, twist
from gaitflow.core.gaits import Pattern
from gaitflow.core.layout import GRAVITY
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.problem import transcribe
from gaitflow.search import starts
from gaitflow.search.screen import NO_STRENGTH, why_impossible
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Start

MOTION = Objective(tangential_velocity=1.0, normal_velocity=1.0, tilt=1.0, tilt_rate=1.0, lateral_foot=1.0)
RANGE = {"start": -1.0, "stop": 1.0, "count": 2}
EXACT = Transcription(knots_per_phase=4, integrator="momentum", forces="linear", grading=0.7)
EULER = Transcription(knots_per_phase=4)


@pytest.mark.parametrize("rate", [0.0, 0.4, -1.5])
@pytest.mark.parametrize("transcription", [EXACT, EULER], ids=["exact", "euler"])
def test_a_glide_along_the_command_repeats_and_costs_nothing(
    anymal: Scenario, transcription: Transcription, rate: float
) -> None:
    """`starts.nominal` follows (v, v_y, yaw rate): eq. (3) holds, and velocity, tilt and lateral feet cost nothing."""
    turning = with_axes(anymal, yaw_rate=RANGE, lateral_speed=RANGE)
    problem = transcribe(turning.model_copy(update={"objective": MOTION, "transcription": transcription}))
    task = Task.of({"speed": 0.7, "lateral_speed": -0.2, "yaw_rate": rate, "cycle_duration": 0.6})
    w = starts.nominal(anymal.robot, problem.layout, task)
    cost, rows = problem.nlp(w, task.parameters)
    closing = rows.full().ravel()[-1 - problem.layout.nx :]
    np.testing.assert_allclose(closing, 0.0, atol=1e-9)
    # On an arc the exact step's chord is shorter than its path by (w h)^2 / 24 of it.
    longest = 0.25 * 0.6 * problem.layout.shares.max()
    assert float(cost) * problem.cost_scale <= 1e-15 + 10 * (rate * longest) ** 4
    other = task.replaced(yaw_rate=rate + 0.1, lateral_speed=0.0)
    assert float(problem.nlp(w, other.parameters)[0]) * problem.cost_scale > 1e-3, "of another command it does cost"


def best(scenario: Scenario, pattern: Pattern, task: Task, **update: Any) -> Attempt:
    problem = transcribe(scenario.model_copy(update=update))
    start = Start("nominal", starts.nominal(scenario.robot, problem.layout, task))
    attempt = FixedGaitSolver(problem, 20.0).solve(pattern, task, start)
    assert attempt.feasible, attempt.solver_status
    return attempt


@pytest.fixture(scope="module")
def turning(checkout: Path) -> Scenario:
    """A quadruped that is symmetric left to right and front to hind, and may go sidewards, turn and accelerate."""
    scenario = load_scenario(checkout / "tests/data/scenarios/anymal-flat-vibration.yaml")
    data = scenario.robot.as_data()
    data["inertia"] = ((1.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 2.1))
    for leg in data["legs"]:
        leg["default_foot"] = [np.sign(leg["default_foot"][0]) * 0.37, *leg["default_foot"][1:]]
    robot = type(scenario.robot).from_data(data, "test")
    assert robot.reversal_permutation == (2, 3, 0, 1)
    moved = with_axes(scenario, yaw_rate=RANGE, lateral_speed=RANGE, acceleration=RANGE)
    return moved.model_copy(update={"robot": robot})


SIDEWARDS = Task.of({"speed": 0.5, "lateral_speed": 0.15, "yaw_rate": 0.4, "acceleration": 0.3, "cycle_duration": 0.6})
WALK = Pattern.from_text("0111/1101/1011/1110")


def test_a_mirrored_task_has_the_mirrored_optimum(turning: Scenario) -> None:
    mirrored = WALK.mirrored(turning.robot.mirror_permutation)
    one = best(turning, WALK, SIDEWARDS, transcription=EXACT).cost
    other = best(turning, mirrored, SIDEWARDS.mirrored(), transcription=EXACT).cost
    assert other == pytest.approx(one, rel=1e-5)
    assert best(turning, mirrored, SIDEWARDS, transcription=EXACT).cost != pytest.approx(one, rel=1e-4)


def moved_to_start(motion: Trajectory, place: Array, turn: float) -> Trajectory:
    """The motion seen from a frame at `place` [3] m that has turned by `turn` rad."""
    c, s = np.cos(turn), np.sin(turn)
    back = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    base = motion.base
    seen = [(base[:, :3] - place) @ back.T, base[:, 3:6] - [turn, 0.0, 0.0], base[:, 6:9] @ back.T, base[:, 9:]]
    return replace(
        motion,
        base=np.hstack(seen),
        feet=(motion.feet - place) @ back.T,
        forces=motion.forces @ back.T,
        end_forces=motion.end_forces @ back.T,
        foot_velocities=motion.foot_velocities @ back.T,
    )


def cut_later(motion: Trajectory, task: Task, steps: int) -> Trajectory:
    """The same walk, its cycle beginning some steps later: what was left out follows at the end, one cycle on."""
    turn = task["yaw_rate"] * task.cycle_duration
    place = np.append(twist.displacements(task, np.array(task.cycle_duration)), 0.0)
    c, s = np.cos(turn), np.sin(turn)
    ahead = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) @ -place
    following = moved_to_start(motion, ahead, -turn)  # seen from a cycle before, so it lies a cycle ahead
    knots = {name: np.concatenate([getattr(motion, name)[steps:], getattr(following, name)[1 : steps + 1]])
             for name in ("base", "feet")}  # fmt: skip
    controls = {name: np.concatenate([getattr(motion, name)[steps:], getattr(following, name)[:steps]])
                for name in ("forces", "end_forces", "foot_velocities")}  # fmt: skip
    phases = steps * len(motion.durations) // len(motion.forces)
    times = np.concatenate([motion.times[steps:], motion.times[1 : steps + 1] + motion.times[-1]]) - motion.times[steps]
    later = Trajectory(times=times, **knots, **controls, durations=np.roll(motion.durations, -phases))
    begins = motion.times[steps]
    start = np.append(twist.displacements(task, np.array(begins)), 0.0)
    return moved_to_start(later, start, task["yaw_rate"] * begins)


@pytest.mark.parametrize("transcription", [EXACT, EULER], ids=["exact", "euler"])
def test_a_walk_does_not_depend_on_where_its_cycle_is_cut(turning: Scenario, transcription: Transcription) -> None:
    """Nor while it turns: limits and costs are seen from the frame that follows the twist. So one pattern of a gait
    stands for all its rotations."""
    scenario, task = turning.model_copy(update={"transcription": transcription}), SIDEWARDS.replaced(acceleration=0.0)
    motion, data = best(scenario, WALK, task).trajectory, scenario.as_data()
    cost = check.cost(data, motion, task)
    for phases in (1, 3):
        later = cut_later(motion, task, 4 * phases)
        assert check.worst(data, later, task, WALK.rotated(phases).text) <= check.FEASIBLE
        assert check.cost(data, later, task) == pytest.approx(cost, rel=1e-6)


def reversed_motion(motion: Trajectory, task: Task, legs: tuple[int, ...]) -> Trajectory:
    """The image in a plane across the path, with time running backwards, that begins where the command begins.

    Reflecting x turns round x of a vector, and y and z of a rotation; time turns round what is a velocity.
    """
    flip, spin = np.array([-1.0, 1.0, 1.0]), np.array([-1.0, -1.0, 1.0])  # yaw and pitch turn round, roll does not
    base = motion.base
    reflected = [base[:, :3] * flip, base[:, 3:6] * spin, -base[:, 6:9] * flip, base[:, 9:] * flip]
    image = Trajectory(
        times=motion.times[-1] - motion.times[::-1],
        base=np.hstack(reflected)[::-1],
        feet=(motion.feet[:, legs] * flip)[::-1],
        forces=(motion.end_forces[:, legs] * flip)[::-1],
        end_forces=(motion.forces[:, legs] * flip)[::-1],
        foot_velocities=-(motion.foot_velocities[:, legs] * flip)[::-1],
        durations=motion.durations[::-1],
    )
    last = np.append(twist.displacements(task, np.array(task.cycle_duration)), 0.0)
    return moved_to_start(image, last * flip, -task["yaw_rate"] * task.cycle_duration)


def test_a_motion_run_backwards_is_one_of_the_reversed_task(turning: Scenario) -> None:
    """With front and hind swapped: sidewards and acceleration change their sign, turning does not."""
    swap = turning.robot.reversal_permutation
    assert swap is not None
    exact = turning.model_copy(update={"transcription": EXACT})
    motion, data = best(exact, WALK, SIDEWARDS).trajectory, exact.as_data()
    image, task, pattern = reversed_motion(motion, SIDEWARDS, swap), SIDEWARDS.time_reversed(), WALK.reversed(swap)
    assert check.worst(data, image, task, pattern.text) <= check.FEASIBLE
    assert check.cost(data, image, task) == pytest.approx(check.cost(data, motion, SIDEWARDS), rel=1e-6)
    assert check.worst(data, image, SIDEWARDS, pattern.text) > 1e-3, "of the task itself it is none"
    euler = turning.model_copy(update={"transcription": EULER})
    discrete = best(euler, WALK, SIDEWARDS).trajectory
    backwards = reversed_motion(discrete, SIDEWARDS, swap)
    assert check.worst(euler.as_data(), backwards, task, pattern.text) > 1e-3, "Euler's motions have no such image"


@pytest.mark.parametrize(("speed", "pattern"), [(0.9, "0011/0110"), (1.2, "0110/1100"), (0.5, "0111/1110")])
def test_time_reversal_in_the_plane(planar: Scenario, speed: float, pattern: str) -> None:
    """Up a slope and speeding up is down it and slowing down, run backwards: to the solver's last digits.

    The paper's Euler steps tell the two apart, by more than most gaits differ.
    """
    scenario = with_axes(planar, slope=RANGE, acceleration=RANGE)
    task = Task.of({"speed": speed, "cycle_duration": 0.6, "slope": 6.0, "acceleration": 0.4})
    there = Pattern.from_text(pattern)
    back = there.reversed((1, 0))
    costs = {
        name: (
            best(scenario, there, task, transcription=transcription).cost,
            best(scenario, back, task.time_reversed(), transcription=transcription).cost,
        )
        for name, transcription in (("exact", EXACT), ("euler", EULER))
    }
    assert costs["exact"][0] == pytest.approx(costs["exact"][1], rel=1e-6)
    assert costs["euler"][0] != pytest.approx(costs["euler"][1], rel=1e-2)


def test_while_it_speeds_up_a_walk_depends_on_where_its_cycle_is_cut(planar: Scenario) -> None:
    """A cycle is faster at its end than at its beginning, so its rotations are other motions."""
    scenario = with_axes(planar, slope=0.0, acceleration=RANGE).model_copy(update={"transcription": EXACT})
    task = Task.of({"speed": 0.9, "cycle_duration": 0.6, "acceleration": 0.5})
    gallop = Pattern.from_text("0110/1100")
    costs = [best(scenario, gallop.rotated(cut), task).cost for cut in range(4)]
    assert max(costs) > 1.1 * min(costs)
    steady = task.replaced(acceleration=0.0)
    costs = [best(scenario, gallop.rotated(cut), steady).cost for cut in range(4)]
    assert max(costs) == pytest.approx(min(costs), rel=1e-6)


def test_patterns_are_merged_only_where_the_task_is_its_own_image(turning: Scenario, planar: Scenario) -> None:
    exact = turning.model_copy(update={"transcription": EXACT})
    straight = Task.of({"speed": 0.5, "cycle_duration": 0.6})
    expected = {
        straight: ((1, 0, 3, 2), (2, 3, 0, 1)),
        straight.replaced(yaw_rate=0.4): (None, (2, 3, 0, 1)),
        straight.replaced(lateral_speed=0.1): (None, None),
        straight.replaced(acceleration=0.1): ((1, 0, 3, 2), None),  # and where the cycle is cut counts
    }
    for task, (mirror, reversal) in expected.items():
        found = exact.symmetry(task)
        assert (found.mirror, found.reversal) == (mirror, reversal), task.text(("yaw_rate", "lateral_speed"))
        assert found.rotation == (task["acceleration"] == 0)
    assert turning.symmetry(straight).reversal is None, "Euler's steps are not symmetric in time"
    up = Task.of({"speed": 0.5, "cycle_duration": 0.6, "slope": 20.0})
    level = planar.model_copy(update={"transcription": EXACT})
    assert (level.symmetry(up).reversal, level.symmetry(straight).reversal) == (None, (1, 0))
    assert level.symmetry(straight).mirror is None, "a planar robot has no left and right"


@pytest.mark.parametrize("transcription", [EXACT, EULER], ids=["exact", "euler"])
def test_a_payload_is_carried_like_the_body_itself(planar: Scenario, transcription: Transcription) -> None:
    """On the spot, on all feet, the least force is half of the weight on each: J1 grows with the mass' square."""
    carrying = with_axes(planar, speed=RANGE, payload={"start": 0.0, "stop": 20.0, "count": 2})
    update = {"objective": Objective(force=1.0), "transcription": transcription}
    standing, mass = Pattern.from_text("1111/1111"), planar.robot.mass
    for payload in (0.0, mass):
        task = Task.of({"speed": 0.0, "cycle_duration": 0.6, "payload": payload})
        expected = 0.6 * ((mass + payload) * GRAVITY) ** 2 / 2
        assert best(carrying, standing, task, **update).cost == pytest.approx(expected, rel=1e-4)
    bearable = task.replaced(payload=planar.robot.max_force * 2 / GRAVITY - mass)
    assert why_impossible(carrying, standing, bearable) is None
    assert why_impossible(carrying, standing, bearable.replaced(payload=bearable["payload"] * 1.1)) == NO_STRENGTH
