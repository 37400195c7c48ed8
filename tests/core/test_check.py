"""The check against the transcription it must not share code with, and against violations planted one by one."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.core.check import FEASIBLE, between_knots, cost, violations, worst
from gaitflow.core.gaits import Pattern
from gaitflow.core.layout import GRAVITY
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.search import starts
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Start

SPEED, CYCLE = 0.9, 0.6
GALLOP, TROT = "0110/1100", "0011/1100/1100/0011"
EXACT = {"forces": "linear", "grading": 0.7}
# Axes besides speed and cycle duration, by what they do.
UPHILL = {"slope": 20.0, "acceleration": 0.4}
TURNING = {"yaw_rate": 0.7, "lateral_speed": 0.2, "acceleration": 0.3, "friction": 0.6}
DOWNHILL = {"slope": -10.0, "lateral_speed": 0.1, "friction": 0.6}


def made(checkout: Path, name: str, axes: dict[str, float], **transcription: Any) -> Scenario:
    """A scenario of the tests' own whose other axes are fixed, with 4 knots a phase."""
    data = load_scenario(checkout / f"tests/data/scenarios/{name}.yaml").as_data()
    data["tasks"]["axes"] = {key: data["tasks"]["axes"][key] for key in ("speed", "cycle_duration")} | axes
    data["transcription"].update({"knots_per_phase": 4, **transcription})
    if data["robot"]["dimension"] == 3:
        data["robot"]["inertia"] = ((1.004, 0.0, -0.2), (0.0, 2.078, 0.0), (-0.2, 0.0, 2.082))
    return Scenario.from_data(data, "test")


def task_of(scenario: Scenario, speed: float = SPEED) -> Task:
    return scenario.tasks.space.task({"speed": speed, "cycle_duration": CYCLE})


def solved(scenario: Scenario, pattern: str, task: Task) -> Attempt:
    problem = transcribe(scenario)
    start = Start("nominal", starts.nominal(scenario.robot, problem.layout, task))
    attempt = FixedGaitSolver(problem, 20.0).solve(Pattern.from_text(pattern), task, start)
    assert attempt.feasible, attempt
    return attempt


@pytest.fixture(scope="module")
def planar(checkout: Path) -> Scenario:
    """Up a slope of 20 degrees, the paper's Euler steps."""
    return made(checkout, "planar-slope20-vibration", {"slope": 20.0})


@pytest.fixture(scope="module")
def gallop(planar: Scenario) -> Trajectory:
    return solved(planar, GALLOP, task_of(planar)).trajectory


@pytest.fixture(scope="module")
def exact(checkout: Path) -> Scenario:
    """The same with a step that is exact in momentum, linear forces and graded knots."""
    return made(checkout, "planar-slope20-vibration", {"slope": 20.0}, integrator="momentum", **EXACT)


@pytest.fixture(scope="module")
def exact_gallop(exact: Scenario) -> Trajectory:
    return solved(exact, GALLOP, task_of(exact)).trajectory


def anywhere(problem: GaitProblem, task: Task, seed: int) -> tuple[Array, Trajectory]:
    """A trajectory that obeys nothing, but for feet inside their boxes at the last knot, where no row holds them.

    With the integrator `momentum`, whose rows are written in another way than ours, the centre of mass moves as its
    forces say and feet stand: then what is left over, of the angles and the angular momentum, is the same.
    """
    scenario, layout = problem.scenario, problem.layout
    d, a = layout.dimension, layout.angles
    w = starts.random(scenario.robot, layout, task, np.random.default_rng(seed))
    default = np.array([leg.default_foot for leg in scenario.robot.legs])
    if scenario.transcription.integrator == "momentum":
        random = layout.unpack(w, CYCLE)
        gravity = -GRAVITY * np.array([math.sin(math.radians(task["slope"])), 0, math.cos(math.radians(task["slope"]))])
        for k, h in enumerate(np.diff(random.times)):
            first, last = (
                force[k].sum(axis=0) / scenario.robot.mass + gravity[[0, 2] if d == 2 else slice(None)]
                for force in (random.forces, random.end_forces)
            )
            velocity = random.base[k, d + a : 2 * d + a]
            random.base[k + 1, :d] = random.base[k, :d] + h * velocity + h**2 * (first / 3 + last / 6)
            random.base[k + 1, d + a : 2 * d + a] = velocity + h / 2 * (first + last)
        random.base[-1, d : d + a] = 0.0
        random.feet[:] = random.base[-1, :d] + default
        return layout.pack(random, CYCLE), random
    base = np.zeros(layout.nb)
    base[d - 1] = 0.5
    w[layout.state(layout.steps)] = np.append(base, base[:d] + default)
    return w, layout.unpack(w, CYCLE)


@pytest.mark.parametrize(("name", "axes"), [
    ("planar-slope20-vibration", UPHILL), ("anymal-flat-vibration", TURNING), ("anymal-flat-vibration", DOWNHILL),
], ids=["plane", "turning", "downhill"])  # fmt: skip
@pytest.mark.parametrize(("integrator", "forces", "grading"), [
    ("euler", "held", 0.0),
    ("euler", "held", 0.5),
    ("rk4", "held", 0.0),
    ("rk4", "linear", 0.7),
    ("midpoint", "held", 0.7),
    ("midpoint", "linear", 0.7),
    ("hermite_simpson", "linear", 0.7),
    ("momentum", "held", 0.0),
    ("momentum", "linear", 0.7),
])  # fmt: skip
def test_agrees_with_the_rows_of_the_program(
    checkout: Path, name: str, axes: dict[str, float], integrator: str, forces: str, grading: float
) -> None:
    problem = transcribe(made(checkout, name, axes, integrator=integrator, forces=forces, grading=grading))
    scenario, layout, robot = problem.scenario, problem.layout, problem.scenario.robot
    d, steps, legs = layout.dimension, layout.steps, layout.legs
    middles = 0 if integrator == "euler" else steps
    nodes = steps + (layout.phases if forces == "linear" else 0)
    speeds = steps * legs * 2 if "yaw_rate" in axes else 0  # else they are bounds
    sizes = [steps * layout.nx, (steps + middles) * legs * d, nodes * legs * 2 * (d - 1), speeds, layout.nx, 1]
    task = task_of(scenario)
    for seed in range(3):
        w, trajectory = anywhere(problem, task, seed)
        rows = problem.nlp(w, task.parameters)[1].full().ravel()
        assert len(rows) == sum(sizes)
        defects, offsets, cones, turned, closing, cycle = np.split(rows, np.cumsum(sizes)[:-1])
        defects = defects.reshape(steps, layout.nx)
        found = violations(scenario.as_data(), trajectory, task, "/".join(["1111"] * legs))
        expected = {
            "dynamics": np.abs(defects[:, : layout.nb]).max(),
            "foot motion": np.abs(defects[:, layout.nb :]).max(),
            "kinematic box": (np.abs(offsets.reshape(-1, d)) - robot.box).max(),
            "friction": cones.max(),
            "periodicity": np.abs(closing).max(),
            "cycle": abs(cycle[0]),
        }
        if speeds:
            upwards = np.abs(trajectory.foot_velocities[..., -1]).max()
            expected["foot speed"] = max(
                0.0, np.abs(turned).max() - robot.max_foot_speed, upwards - robot.max_foot_speed
            )
        assert {kind: found[kind] for kind in expected} == pytest.approx(expected, rel=1e-9, abs=1e-12)
        assert min(expected.values()) >= 0
        assert found["clock"] < 1e-12 and found["force course"] == 0.0
        assert expected["dynamics"] > 0.01


@pytest.mark.parametrize("integrator", ["euler", "rk4", "midpoint", "hermite_simpson", "momentum"])
def test_a_solved_motion_in_the_plane_passes(checkout: Path, integrator: str) -> None:
    settings = {} if integrator == "euler" else EXACT
    scenario = made(checkout, "planar-slope20-vibration", UPHILL, integrator=integrator, **settings)
    data, task = scenario.as_data(), task_of(scenario)
    attempt = solved(scenario, GALLOP, task)
    assert worst(data, attempt.trajectory, task, GALLOP) <= FEASIBLE
    seen = between_knots(data, attempt.trajectory, task, GALLOP)
    if integrator == "euler":
        assert cost(data, attempt.trajectory, task) == pytest.approx(attempt.cost, rel=1e-9)
        assert seen["dynamics"] > 1e-3, "Euler at 16 steps is far from a motion between its knots"
    elif integrator != "midpoint":
        assert cost(data, attempt.trajectory, task) == pytest.approx(attempt.cost, rel=3e-3)
        assert seen["dynamics"] < 1e-3 and seen["friction"] < 1e-6 and seen["penetration"] < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("axes", [{}, TURNING, DOWNHILL], ids=["straight", "turning", "downhill"])
@pytest.mark.parametrize("integrator", ["euler", "midpoint", "hermite_simpson", "momentum"])
def test_a_solved_motion_in_space_passes(checkout: Path, integrator: str, axes: dict[str, float]) -> None:
    settings = {} if integrator == "euler" else EXACT
    scenario = made(checkout, "anymal-flat-vibration", axes, integrator=integrator, **settings)
    data, task = scenario.as_data(), task_of(scenario, 0.4)
    attempt = solved(scenario, TROT, task)
    assert worst(data, attempt.trajectory, task, TROT) <= FEASIBLE
    assert cost(data, attempt.trajectory, task) == pytest.approx(
        attempt.cost, rel={"euler": 1e-9, "midpoint": 0.1}.get(integrator, 3e-3)
    )


@pytest.mark.parametrize(("name", "pattern", "speed", "axes"), [
    ("planar-flat-effort", GALLOP, 0.9, {}),
    ("planar-slope20-vibration", GALLOP, 0.9, UPHILL),
    ("planar-slope20-vibration", "0001/0100", 1.5, {}),
    ("anymal-flat-vibration", TROT, 0.4, TURNING),
])  # fmt: skip
def test_the_exact_steps_cost_is_right_to_a_thousandth(
    checkout: Path, name: str, pattern: str, speed: float, axes: dict[str, float]
) -> None:
    """With the paper's 10 knots a phase; and between the knots position and rotation are right to 1e-4."""
    scenario = made(checkout, name, axes, integrator="momentum", knots_per_phase=10, **EXACT)
    data, task = scenario.as_data(), task_of(scenario, speed)
    attempt = solved(scenario, pattern, task)
    assert worst(data, attempt.trajectory, task, pattern) <= FEASIBLE
    assert cost(data, attempt.trajectory, task) == pytest.approx(attempt.cost, rel=1e-3)
    seen = between_knots(data, attempt.trajectory, task, pattern)
    assert seen["dynamics"] < 1e-4 and seen["friction"] < 1e-2 and seen["penetration"] < 1e-3


# In the gallop 0110/1100 with 4 knots a phase: the front leg F = 0 stands in steps 4..11, the hind leg H = 1 in 0..7.
F, H, EPS = 0, 1, 1e-3


def _base(trajectory: Trajectory) -> None:
    trajectory.base[6, 4] += EPS


def _foot_velocity(trajectory: Trajectory) -> None:
    trajectory.foot_velocities[13, F, 1] += EPS


def _last_height(trajectory: Trajectory) -> None:
    trajectory.base[-1, 2] += EPS


def _crouch(trajectory: Trajectory) -> None:
    trajectory.base[:, 1] -= 0.5


def _tangential(trajectory: Trajectory) -> None:
    trajectory.forces[6, F, 0] = trajectory.end_forces[6, F, 0] = 0.8 * trajectory.forces[6, F, 1] + 1.0


def _pull(trajectory: Trajectory) -> None:
    trajectory.forces[6, F] = trajectory.end_forces[6, F] = (0.0, -1.0)


def _strong(trajectory: Trajectory) -> None:
    trajectory.forces[6, F, 1] = trajectory.end_forces[6, F, 1] = 501.0


def _dig(trajectory: Trajectory) -> None:
    trajectory.feet[14, F, 1] = -EPS


def _push_air(trajectory: Trajectory) -> None:
    trajectory.forces[13, F, 1] = trajectory.end_forces[13, F, 1] = 1.0


def _ramp(trajectory: Trajectory) -> None:
    trajectory.end_forces[6, F, 1] -= 1.0


def _kick(trajectory: Trajectory) -> None:
    trajectory.feet[13, F, 1] = 0.7 + EPS  # the longest leg of the box: 0.5 m and 0.2 m


def _slip(trajectory: Trajectory) -> None:
    trajectory.feet[6, F, 0] += EPS


def _lift(trajectory: Trajectory) -> None:
    trajectory.feet[4:13, F, 1] += EPS


def _fast(trajectory: Trajectory) -> None:
    trajectory.foot_velocities[13, F, 0] = 8.5


def _tilt(trajectory: Trajectory) -> None:
    trajectory.base[:, 2] = 1.25


def _long(trajectory: Trajectory) -> None:
    trajectory.durations[2] += EPS


def _late(trajectory: Trajectory) -> None:
    trajectory.times[6:] += EPS


def _short(trajectory: Trajectory) -> None:
    trajectory.durations[:] = (0.05 * CYCLE, 0.35 * CYCLE, 0.3 * CYCLE, 0.3 * CYCLE)


WEIGHT = 14.0 * GRAVITY
PLANTED: list[tuple[Callable[[Trajectory], None], str, float, set[str]]] = [
    (_base, "dynamics", EPS, set()),
    (_foot_velocity, "foot motion", math.nan, set()),
    (_last_height, "periodicity", EPS, {"dynamics"}),
    (_crouch, "kinematic box", math.nan, {"dynamics"}),
    (_tangential, "friction", 1.0 / WEIGHT, {"dynamics"}),
    (_pull, "unilaterality", 1.0 / WEIGHT, {"dynamics", "friction"}),
    (_strong, "force limit", 1.0 / WEIGHT, {"dynamics"}),
    (_dig, "penetration", EPS, {"foot motion", "kinematic box"}),
    (_kick, "foot height", EPS, {"foot motion", "kinematic box"}),
    (_ramp, "force course", 1.0 / WEIGHT, {"friction"}),
    (_push_air, "force in swing", 1.0 / WEIGHT, {"dynamics"}),
    (_slip, "slip in stance", EPS, {"dynamics", "foot motion"}),
    (_lift, "lift in stance", EPS, {"dynamics", "foot motion", "kinematic box"}),
    (_fast, "foot speed", 0.5, {"foot motion"}),
    (_tilt, "tilt", 0.25, {"dynamics", "kinematic box"}),
    (_long, "cycle", EPS / CYCLE, {"dynamics", "foot motion", "clock"}),
    (_late, "clock", EPS / CYCLE, set()),
    (_short, "phase duration", 0.05, {"dynamics", "foot motion", "clock"}),
]


@pytest.mark.parametrize(("plant", "kind", "size", "also"), PLANTED, ids=[kind for _, kind, _, _ in PLANTED])
def test_finds_a_planted_violation_and_names_it(
    planar: Scenario, gallop: Trajectory, plant: Callable[[Trajectory], None], kind: str, size: float, also: set[str]
) -> None:
    """`also` are the conditions that no such change can leave intact; nothing else may be blamed."""
    spoilt = Trajectory(*(getattr(gallop, field.name).copy() for field in fields(Trajectory)))
    plant(spoilt)
    found = violations(planar.as_data(), spoilt, task_of(planar), GALLOP)
    broken = {name for name, value in found.items() if value > FEASIBLE}
    assert kind in broken
    assert broken <= {kind} | also
    if not math.isnan(size):
        assert found[kind] == pytest.approx(size, rel=0.02)
    assert worst(planar.as_data(), spoilt, task_of(planar), GALLOP) == max(found.values()) > FEASIBLE


def test_every_kind_is_planted(planar: Scenario, gallop: Trajectory) -> None:
    kinds = violations(planar.as_data(), gallop, task_of(planar), GALLOP)
    assert set(kinds) == {kind for _, kind, _, _ in PLANTED}


def test_a_low_swing_is_planted_where_a_scenario_asks_for_clearance(planar: Scenario, gallop: Trajectory) -> None:
    """F swings in steps 12..15 and 0..3: knots 0 and 16, one place of the cycle, are the middle."""
    asking = planar.as_data() | {"swing_clearance": 0.1}
    high = Trajectory(*(getattr(gallop, field.name).copy() for field in fields(Trajectory)))
    high.feet[[0, 16], F, 1] = high.feet[12, H, 1] = 0.1
    found = violations(asking, high, task_of(planar), GALLOP)
    assert found["swing clearance"] == 0.0
    for leg, knots in ((F, [0, 16]), (H, [12])):
        spoilt = replace(high, feet=high.feet.copy())
        spoilt.feet[knots, leg, 1] -= EPS
        assert violations(asking, spoilt, task_of(planar), GALLOP)["swing clearance"] == pytest.approx(EPS)
        spoilt.feet[11, F, 1] = spoilt.feet[9, H, 1] = spoilt.feet[15, H, 1] = 0.0  # no middle
        assert violations(asking, spoilt, task_of(planar), GALLOP)["swing clearance"] == pytest.approx(EPS)
    assert set(found) - {"swing clearance"} == set(violations(planar.as_data(), high, task_of(planar), GALLOP))


# The same gallop with exact steps: knots 4..12 are the front leg's stance, as before.
def _jump(trajectory: Trajectory) -> None:
    trajectory.end_forces[5, F, 1] += 1.0  # step 6 of the same phase begins where it was


def _slide_at_the_end(trajectory: Trajectory) -> None:
    trajectory.end_forces[7, F, 0] = 0.8 * trajectory.end_forces[7, F, 1] + 1.0


def _last_push(trajectory: Trajectory) -> None:
    trajectory.end_forces[15, F, 1] = 1.0


def _last_pull(trajectory: Trajectory) -> None:
    trajectory.end_forces[7, F] = (0.0, -1.0)


def _bow(trajectory: Trajectory) -> None:
    trajectory.base[5, 4] -= 40.0  # from knot to knot the cubic bows out of the box in the middle
    trajectory.base[6, 4] += 40.0


def _even(trajectory: Trajectory) -> None:
    ends = np.append(0.0, np.cumsum(trajectory.durations))
    trajectory.times[:] = np.interp(np.arange(17), np.arange(0, 17, 4), ends)


PLANTED_EXACT: list[tuple[Callable[[Trajectory], None], str, float, set[str]]] = [
    (_base, "dynamics", math.nan, set()),
    (_jump, "force course", 1.0 / WEIGHT, {"dynamics"}),
    (_slide_at_the_end, "friction", 1.0 / WEIGHT, {"dynamics"}),
    (_last_push, "force in swing", 1.0 / WEIGHT, {"dynamics"}),
    (_last_pull, "unilaterality", 1.0 / WEIGHT, {"dynamics", "friction"}),
    (_bow, "kinematic box", math.nan, {"dynamics"}),
    (_even, "clock", math.nan, set()),
]


@pytest.mark.parametrize(
    ("plant", "kind", "size", "also"), PLANTED_EXACT, ids=[kind for _, kind, _, _ in PLANTED_EXACT]
)
def test_finds_what_only_exact_steps_can_do_wrong(
    exact: Scenario,
    exact_gallop: Trajectory,
    plant: Callable[[Trajectory], None],
    kind: str,
    size: float,
    also: set[str],
) -> None:
    spoilt = Trajectory(*(getattr(exact_gallop, field.name).copy() for field in fields(Trajectory)))
    plant(spoilt)
    found = violations(exact.as_data(), spoilt, task_of(exact), GALLOP)
    broken = {name for name, value in found.items() if value > FEASIBLE}
    assert kind in broken
    assert broken <= {kind} | also
    if not math.isnan(size):
        assert found[kind] == pytest.approx(size, rel=0.02)


@pytest.mark.parametrize("name", [field.name for field in fields(Trajectory)])
def test_no_number_can_change_unseen(exact: Scenario, exact_gallop: Trajectory, name: str) -> None:
    """Every number of an exact motion but where a path begins is held by some condition."""
    data, task = exact.as_data(), task_of(exact)
    before, size = getattr(exact_gallop, name), getattr(exact_gallop, name).size
    for place in range(0, size, max(1, size // 40)):
        changed = before.copy()
        changed.flat[place] += 1e-2 * (exact.robot.mass * GRAVITY if "forces" in name else 1.0)
        assert worst(data, replace(exact_gallop, **{name: changed}), task, GALLOP) > FEASIBLE, (name, place)


@pytest.mark.parametrize(("change", "kinds"), [
    ({"speed": SPEED + EPS}, {"periodicity"}),
    # Two of its phases are as short as can be.
    ({"cycle_duration": CYCLE * 1.01}, {"periodicity", "cycle", "phase duration"}),
    ({"acceleration": EPS}, {"periodicity"}),
    ({"slope": 20.1}, {"dynamics"}),
    ({"friction": 0.01}, {"friction"}),
])  # fmt: skip
def test_a_motion_of_another_task_is_refused(
    planar: Scenario, gallop: Trajectory, change: dict[str, float], kinds: set[str]
) -> None:
    found = violations(planar.as_data(), gallop, task_of(planar).replaced(**change), GALLOP)
    assert {kind for kind, value in found.items() if value > FEASIBLE} == kinds


def test_a_motion_of_another_pattern_is_refused(planar: Scenario, gallop: Trajectory) -> None:
    for pattern, kind in (("0100/1100", "force in swing"), ("0111/1100", "slip in stance")):
        assert violations(planar.as_data(), gallop, task_of(planar), pattern)[kind] > 0.01


@pytest.mark.parametrize("pattern", ["0110", "011/110", "0110/1100/0011", "0110/11a0", ""])
def test_a_pattern_of_another_shape_is_an_error(planar: Scenario, gallop: Trajectory, pattern: str) -> None:
    with pytest.raises(ValueError, match="the scenario has 2 legs and 4 phases"):
        violations(planar.as_data(), gallop, task_of(planar), pattern)


@pytest.mark.parametrize("name", [field.name for field in fields(Trajectory)])
def test_arrays_of_another_shape_are_infinitely_wrong(planar: Scenario, gallop: Trajectory, name: str) -> None:
    array = getattr(gallop, name)
    for other in (array[:-1], array[..., None], np.zeros(())):
        assert worst(planar.as_data(), replace(gallop, **{name: other}), task_of(planar), GALLOP) == math.inf


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", [field.name for field in fields(Trajectory)])
def test_numbers_that_overflow_are_no_motion(exact: Scenario, exact_gallop: Trajectory, name: str) -> None:
    """Every comparison with a NaN is false, so none may be left over."""
    for huge in (1e200, -1e308):
        array = np.full_like(getattr(exact_gallop, name), huge)
        found = violations(exact.as_data(), replace(exact_gallop, **{name: array}), task_of(exact), GALLOP)
        assert max(found.values()) > 1e100 and not any(math.isnan(value) for value in found.values())


def test_an_unknown_integrator_is_an_error(planar: Scenario, gallop: Trajectory) -> None:
    data = planar.as_data()
    data["transcription"]["integrator"] = "leapfrog"
    with pytest.raises(ValueError, match="'leapfrog' is unknown to the check"):
        worst(data, gallop, task_of(planar), GALLOP)


@pytest.mark.parametrize("name", [field.name for field in fields(Trajectory)])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_what_is_not_a_number_is_infinitely_wrong(
    planar: Scenario, gallop: Trajectory, name: str, value: float
) -> None:
    array = getattr(gallop, name).copy()
    array.flat[array.size // 2] = value
    assert worst(planar.as_data(), replace(gallop, **{name: array}), task_of(planar), GALLOP) == math.inf


def test_the_box_holds_at_the_last_knot_too(planar: Scenario, gallop: Trajectory) -> None:
    """The program leaves it to periodicity; the check must not."""
    far = replace(gallop, feet=gallop.feet.copy())
    far.feet[-1, F, 0] += 1.0
    assert violations(planar.as_data(), far, task_of(planar), GALLOP)["kinematic box"] > 0.5
