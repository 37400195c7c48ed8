"""Switching between motions of published maps: what is planned is feasible, and the robot follows it without a jump."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.core.check import FEASIBLE, between_knots
from gaitflow.core.gaits import Pattern
from gaitflow.core.rigid_body import RigidBody
from gaitflow.problem import transcribe
from gaitflow.runtime import GaitMap, Journey, Motion, NoTransition, standing, switching
from gaitflow.runtime.switching import TransitionPlanner, TransitionProblem, check_switchable
from gaitflow.search import starts
from gaitflow.solvers.fixed_gait import FixedGaitSolver, Start

SMOOTH = (
    "position", "velocity", "orientation", "angular_velocity", "feet", "foot_velocities", "foot_accelerations",
)  # fmt: skip
WALK = "three-beat walk 0011/1110/1110/1001"


@pytest.fixture(scope="module")
def planar(checkout: Path) -> GaitMap:
    return GaitMap.load(checkout / "models/half-cheetah-exact-slopes/1.1.0")


@pytest.fixture(scope="module")
def spatial(checkout: Path) -> GaitMap:
    return GaitMap.load(checkout / "models/anymal-exact-vibration/1.0.0")


@pytest.fixture(scope="module")
def gallop(planar: GaitMap) -> Motion:
    return planar.plan(speed=0.9, cycle_duration=0.6, slope=0.0, gait="gallop").motion()


@pytest.fixture(scope="module")
def bounding(planar: GaitMap) -> Motion:
    return planar.plan(speed=1.5, cycle_duration=0.5, slope=0.0, gait="bounding").motion()


def follow(journey: Journey) -> None:
    """The transition is feasible, the forces are what moves the body, and nothing jumps on the whole way."""
    transition, plan = journey.transition, journey.transition.plan
    assert plan.violation <= FEASIBLE
    scenario = journey.after.motion.scenario
    gaps = between_knots(scenario, plan.trajectory, plan.task, plan.pattern)
    assert max(gaps["friction"], gaps["penetration"]) < 1e-6, gaps
    assert gaps["dynamics"] < 1e-3, gaps
    borders = np.concatenate(
        [[transition.start, transition.end], *([*leg.starts, leg.joined] for leg in transition.legs)]
    )
    before, after = journey.sample(borders - 1e-9), journey.sample(borders + 1e-9)
    for name in SMOOTH:
        one, other = getattr(before, name), getattr(after, name)
        tolerance = 1e-3 if name == "foot_accelerations" else 1e-6
        np.testing.assert_allclose(one, other, atol=tolerance, err_msg=name)
    times = np.linspace(transition.start - 0.5, journey.settled + 0.5, 3001)
    seen, step = journey.sample(times), times[1] - times[0]
    for number, leg in enumerate(journey.leg_names):
        stances = journey.phases(leg, (times[0], times[-1] + step))
        stands = np.any([(start <= times) & (times < end) for start, end, _ in stances], axis=0)
        at_edges = np.min([np.abs(times - edge) for stance in stances for edge in stance[:2]], axis=0) < 1e-6
        np.testing.assert_array_equal(seen.contact[~at_edges, number], stands[~at_edges])
    moved = np.abs(np.diff(seen.feet, axis=0)).max(axis=(1, 2))
    speeds = np.abs(seen.foot_velocities).max(axis=(1, 2))
    assert (moved <= step * (np.maximum(speeds[1:], speeds[:-1]) + 0.2)).all()
    assert seen.feet[..., -1].min() > -1e-9
    assert np.abs(seen.foot_velocities[seen.contact]).max() == 0.0
    if journey.after.motion.point == "com":
        pushed = RigidBody.of(scenario["robot"], plan.task).acceleration(seen.forces)
        np.testing.assert_allclose(seen.acceleration, pushed, atol=1e-4)
    else:
        slope = np.diff(seen.position, axis=0) / step
        np.testing.assert_allclose(slope, (seen.velocity[1:] + seen.velocity[:-1]) / 2, atol=0.01)


def test_from_a_gallop_to_bounding_and_back_in_the_plane(planar: GaitMap, gallop: Motion, bounding: Motion) -> None:
    journey = planar.switch(gallop, bounding, after=1.23)
    follow(journey)
    assert 1.23 <= journey.transition.start <= 1.23 + gallop.period
    late = journey.settled + np.linspace(0.0, 2.0, 9)
    np.testing.assert_array_equal(journey.sample(late).feet, journey.after.sample(late).feet)
    both = planar.switch(journey, gallop, after=0.0)
    follow(both)
    assert both.transition.start >= journey.settled
    early = np.linspace(0.0, journey.transition.end, 50)
    np.testing.assert_array_equal(both.sample(early).feet, journey.sample(early).feet)


def test_from_a_trot_to_a_slower_walk_in_space(spatial: GaitMap) -> None:
    trot = spatial.plan(speed=0.5, cycle_duration=0.6, gait="trot").motion(point="base")
    walk = spatial.plan(speed=0.3, cycle_duration=0.8, gait=WALK).motion(point="base")
    follow(spatial.switch(trot, walk, after=10.0))


def test_from_standing_to_a_trot_and_to_standing_again(spatial: GaitMap) -> None:
    trot = spatial.plan(speed=0.5, cycle_duration=0.6, gait="trot").motion()
    still = standing(trot)
    started = spatial.switch(still, trot, after=0.3)
    follow(started)
    assert started.transition.start == 0.3
    stopped = spatial.switch(started, still, after=5.0)
    follow(stopped)
    end = stopped.at(20.0)
    assert np.abs(end.velocity).max() < 1e-9
    assert end.contact.all()
    assert 1.0 < end.position[0] < 4.0
    np.testing.assert_allclose(stopped.at(0.1).position, still.at(0.0).position, atol=1e-12)


def test_maps_of_eulers_rule_switch_as_well(checkout: Path) -> None:
    """Their knots do not lie on one motion: what the integral misses is closed over the transition."""
    gait_map = GaitMap.load(checkout / "models/half-cheetah-flat-vibration/1.1.0", trust_code=True)
    gallop, bounding = (
        gait_map.plan(speed=speed, cycle_duration=cycle, gait=gait).motion()
        for speed, cycle, gait in ((0.9, 0.6, "gallop"), (1.5, 0.5, "bounding"))
    )
    transition = (journey := gait_map.switch(gallop, bounding)).transition
    assert transition.plan.violation <= FEASIBLE
    for border in (transition.start, transition.end):
        before, after = journey.at(border - 1e-9), journey.at(border + 1e-9)
        for name in SMOOTH[:-1]:
            np.testing.assert_allclose(getattr(before, name), getattr(after, name), atol=1e-6, err_msg=name)


@pytest.fixture(scope="module")
def saving(checkout: Path) -> tuple[Scenario, Motion, Motion]:
    """ANYmal by least energy, 4 knots a phase: a trot and a slower walk."""
    scenario = load_scenario(checkout / "configs/scenarios/anymal-energy.yaml")
    coarse = scenario.transcription.model_copy(update={"knots_per_phase": 4})
    scenario = scenario.model_copy(update={"transcription": coarse})
    problem = transcribe(scenario)
    solver, motions = FixedGaitSolver(problem, 20.0), []
    for pattern, speed in (("0011/1100/1100/0011", 0.6), ("1110/1011/1011/1110", 0.4)):
        task = scenario.tasks.space.task({"speed": speed, "cycle_duration": 0.6})
        start = Start("nominal", starts.nominal(scenario.robot, problem.layout, task))
        attempt = solver.solve(Pattern.from_text(pattern), task, start)
        assert attempt.feasible, pattern
        motions.append(Motion.of(scenario.as_data(), attempt.trajectory, task, pattern))
    return scenario, motions[0], motions[1]


def test_maps_of_energy_switch_as_well(saving: tuple[Scenario, Motion, Motion]) -> None:
    """Though no map of theirs has an acceleration, and feet are not as fast at both ends of a transition."""
    scenario, trot, walk = saving
    planner = TransitionPlanner(TransitionProblem(scenario.as_data()))
    for one, other in ((trot, walk), (standing(trot), trot)):
        found = planner.plan(one, other)
        assert found.violation <= FEASIBLE
        assert 0.0 < found.cost < 1000.0, "smoothness, over that of forces as large as the weight"


@pytest.mark.parametrize(("name", "lateral"), [("half-cheetah-exact-vibration", False), ("go1-exact-vibration", True)])
def test_transitions_of_maps_with_a_force_rate_are_smooth_ones(checkout: Path, name: str, lateral: bool) -> None:
    """Its jump from a cycle's end to the next start means nothing to them; and no foot of a plane is beside it."""
    data = load_scenario(checkout / f"configs/scenarios/{name}.yaml").as_data()
    data["objective"]["force_rate"] = 1e-6
    smooth = TransitionProblem(data).scenario["objective"]
    assert "force_rate" not in smooth and smooth["tilt"] > 0
    assert (smooth["lateral_foot"] > 0) == lateral


def test_a_robot_is_the_same_with_limbs_and_without(saving: tuple[Scenario, Motion, Motion]) -> None:
    """Maps of before know none."""
    scenario, trot, walk = saving
    data = scenario.as_data()
    before = {key: value for key, value in data["robot"].items() if key != "limbs"}
    check_switchable(data, trot, replace(walk, scenario=data | {"robot": before}))
    with pytest.raises(ValueError, match="of another one"):
        check_switchable(data, trot, other_robot(walk))


def other_robot(motion: Motion) -> Motion:
    robot = motion.scenario["robot"]
    return replace(
        motion, scenario=motion.scenario | {"name": "another", "robot": robot | {"name": "cat", "mass": 4.0}}
    )


def with_task(**values: float) -> Callable[[Motion], Motion]:
    return lambda motion: replace(motion, task=motion.task.replaced(**values))


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        (other_robot, "robot cat of another: the transition's map half-cheetah-exact-slopes is of .* half_cheetah"),
        (lambda motion: replace(motion, swing_apex=None), "swing_apex = None"),
        (lambda motion: replace(motion, point="base"), "point: 'com' and 'base': must be the same"),
        (lambda motion: replace(motion, pattern="0000/0110"), "never sets down the leg F"),
        (with_task(slope=5.0), "slope: 0 and 5: must be the same for both motions"),
        (with_task(acceleration=1.0), "acceleration = 1: a transition leads between motions of constant speed"),
        (with_task(yaw_rate=0.4), "yaw_rate = 0.4: the map half-cheetah-exact-slopes holds it at 0"),
    ],
)
def test_motions_that_no_transition_joins(
    planar: GaitMap, gallop: Motion, bounding: Motion, changed: Callable[[Motion], Motion], words: str
) -> None:
    with pytest.raises(ValueError, match=words):
        planar.switch(gallop, changed(bounding))


@pytest.mark.parametrize("after", [float("nan"), float("inf"), "1", True, None])
def test_a_time_that_is_none(planar: GaitMap, gallop: Motion, bounding: Motion, after: Any) -> None:
    with pytest.raises(ValueError, match=r"after = .*: must be a finite number of seconds"):
        planar.switch(gallop, bounding, after)


def test_what_is_not_found_says_so(
    planar: GaitMap, gallop: Motion, bounding: Motion, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(switching, "LIMIT", 2)
    with pytest.raises(NoTransition, match=r"no transition of 0.55 to 1.1 s from 0011/0110 at speed 0.9 m/s"):
        planar.switch(gallop, bounding)


def test_from_one_turn_into_the_other(checkout: Path) -> None:
    """With a problem of few knots that turns, without a map."""
    data = load_scenario(checkout / "tests/data/scenarios/anymal-flat-vibration.yaml").as_data()
    turns = {"start": -1.0, "stop": 1.0, "count": 3}
    data["tasks"]["axes"] |= {"yaw_rate": turns, "lateral_speed": turns}
    data["transcription"] |= {"knots_per_phase": 4, "integrator": "momentum", "forces": "linear", "grading": 0.7}
    problem = transcribe(scenario := Scenario.from_data(data, "test"))
    motions = []
    for pattern, axes in (
        ("0011/1100/1100/0011", {"speed": 0.5, "yaw_rate": 0.7, "lateral_speed": 0.1}),
        ("0111/1110/1101/1011", {"speed": 0.3, "yaw_rate": -0.4, "lateral_speed": 0.0}),
    ):
        task = scenario.tasks.space.task(axes | {"cycle_duration": 0.6})
        start = Start("nominal", starts.nominal(scenario.robot, problem.layout, task))
        attempt = FixedGaitSolver(problem, 20.0).solve(Pattern.from_text(pattern), task, start)
        assert attempt.feasible
        motions.append(Motion.of(scenario.as_data(), attempt.trajectory, task, pattern))
    plan = TransitionPlanner(TransitionProblem(scenario.as_data())).plan(*motions)
    follow(Journey.of(motions[0], plan, plan.first.since + 2 * motions[0].period, motions[1]))
