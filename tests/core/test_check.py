"""The check against the transcription it must not share code with, and against violations planted one by one."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gaitflow.config.scenario import Scenario, Terrain, Transcription, load_scenario
from gaitflow.core.check import FEASIBLE, step_gaps, violations, worst
from gaitflow.core.gaits import Pattern
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.core.layout import GRAVITY
from gaitflow.search import starts
from gaitflow.solvers.fixed_gait import FixedGaitSolver, Start

SPEED, CYCLE = 0.9, 0.6


@pytest.fixture(scope="module")
def planar(checkout: Path) -> Scenario:
    scenario = load_scenario(checkout / "tests/data/scenarios/planar-slope20-vibration.yaml")
    return scenario.model_copy(update={"transcription": Transcription(knots_per_phase=4)})


@pytest.fixture(scope="module")
def anymal(checkout: Path) -> Scenario:
    scenario = load_scenario(checkout / "tests/data/scenarios/anymal-flat-vibration.yaml")
    robot = scenario.robot.model_copy(update={"inertia": ((1.004, 0.1, -0.2), (0.1, 2.078, 0.05), (-0.2, 0.05, 2.082))})
    return scenario.model_copy(
        update={
            "robot": robot,
            "terrain": Terrain(slope_deg=-10.0, friction=0.6),
            "transcription": Transcription(knots_per_phase=4),
        }
    )


def _solved(scenario: Scenario, pattern: str, speed: float) -> Trajectory:
    problem = transcribe(scenario)
    start = Start("nominal", starts.nominal(scenario.robot, problem.layout, speed, CYCLE))
    attempt = FixedGaitSolver(problem, 20.0).solve(Pattern.from_text(pattern), speed, CYCLE, start)
    assert attempt.feasible, attempt
    return attempt.trajectory


@pytest.fixture(scope="module")
def gallop(planar: Scenario) -> Trajectory:
    return _solved(planar, "0110/1100", SPEED)


def _random(problem: GaitProblem, seed: int) -> tuple[Array, Trajectory]:
    """A trajectory that obeys nothing, but for feet inside their boxes at the last knot, where no row holds them."""
    scenario, layout = problem.scenario, problem.layout
    w = starts.random(scenario.robot, layout, SPEED, CYCLE, np.random.default_rng(seed))
    base = np.zeros(layout.nb)
    base[layout.dimension - 1] = 0.5
    feet = base[: layout.dimension] + np.array([leg.default_foot for leg in scenario.robot.legs])
    w[layout.state(layout.steps)] = np.append(base, feet)
    return w, layout.unpack(w, CYCLE)


@pytest.mark.parametrize("name", ["planar", "anymal"])
@pytest.mark.parametrize("integrator", ["euler", "rk4"])
@pytest.mark.parametrize("seed", range(4))
def test_agrees_with_the_rows_of_the_program(
    request: pytest.FixtureRequest, name: str, integrator: str, seed: int
) -> None:
    scenario: Scenario = request.getfixturevalue(name)
    transcription = scenario.transcription.model_copy(update={"integrator": integrator})
    problem = transcribe(scenario.model_copy(update={"transcription": transcription}))
    layout, robot = problem.layout, scenario.robot
    d, steps = layout.dimension, layout.steps
    w, trajectory = _random(problem, seed)
    rows = problem.nlp(w, [SPEED, CYCLE])[1].full().ravel()
    sizes = [steps * layout.nx, steps * layout.legs * d, steps * layout.legs * 2 * (d - 1), layout.nx, 1]
    defects, offsets, cones, closing, cycle = np.split(rows, np.cumsum(sizes)[:-1])
    defects = defects.reshape(steps, layout.nx)
    found = violations(problem.scenario.as_data(), trajectory, SPEED, CYCLE, "/".join(["1111"] * layout.legs))
    expected = {
        "dynamics": np.abs(defects[:, : layout.nb]).max(),
        "foot motion": np.abs(defects[:, layout.nb :]).max(),
        "kinematic box": (np.abs(offsets.reshape(-1, d)) - robot.box).max(),
        "friction": cones.max(),
        "periodicity": np.abs(closing).max(),
        "cycle": abs(cycle[0]),
    }
    assert {kind: found[kind] for kind in expected} == pytest.approx(expected, rel=1e-9, abs=1e-12)
    assert min(expected.values()) >= 0


def test_a_solved_motion_passes(planar: Scenario, anymal: Scenario, gallop: Trajectory) -> None:
    assert worst(planar.as_data(), gallop, SPEED, CYCLE, "0110/1100") <= FEASIBLE
    trot = _solved(anymal, "0011/1100/1100/0011", 0.4)
    assert worst(anymal.as_data(), trot, 0.4, CYCLE, "0011/1100/1100/0011") <= FEASIBLE


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
    trajectory.forces[6, F, 0] = 0.8 * trajectory.forces[6, F, 1] + 1.0


def _pull(trajectory: Trajectory) -> None:
    trajectory.forces[6, F] = (0.0, -1.0)


def _strong(trajectory: Trajectory) -> None:
    trajectory.forces[6, F, 1] = 501.0


def _dig(trajectory: Trajectory) -> None:
    trajectory.feet[14, F, 1] = -EPS


def _push_air(trajectory: Trajectory) -> None:
    trajectory.forces[13, F, 1] = 1.0


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
    found = violations(planar.as_data(), spoilt, SPEED, CYCLE, "0110/1100")
    broken = {name for name, value in found.items() if value > FEASIBLE}
    assert kind in broken
    assert broken <= {kind} | also
    if not math.isnan(size):
        assert found[kind] == pytest.approx(size, rel=0.02)
    assert worst(planar.as_data(), spoilt, SPEED, CYCLE, "0110/1100") == max(found.values()) > FEASIBLE


def test_every_kind_is_planted(planar: Scenario, gallop: Trajectory) -> None:
    kinds = violations(planar.as_data(), gallop, SPEED, CYCLE, "0110/1100")
    assert set(kinds) == {kind for _, kind, _, _ in PLANTED}


@pytest.mark.parametrize(("speed", "cycle", "kinds"), [
    (SPEED + EPS, CYCLE, {"periodicity"}),
    (SPEED, CYCLE * 1.01, {"periodicity", "cycle", "phase duration"}),  # two of its phases are as short as can be
])  # fmt: skip
def test_a_motion_of_another_task_is_refused(
    planar: Scenario, gallop: Trajectory, speed: float, cycle: float, kinds: set[str]
) -> None:
    found = violations(planar.as_data(), gallop, speed, cycle, "0110/1100")
    assert {kind for kind, value in found.items() if value > FEASIBLE} == kinds


def test_a_motion_of_another_pattern_is_refused(planar: Scenario, gallop: Trajectory) -> None:
    for pattern, kind in (("0100/1100", "force in swing"), ("0111/1100", "slip in stance")):
        assert violations(planar.as_data(), gallop, SPEED, CYCLE, pattern)[kind] > 0.01


@pytest.mark.parametrize("name", [field.name for field in fields(Trajectory)])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_what_is_not_a_number_is_infinitely_wrong(
    planar: Scenario, gallop: Trajectory, name: str, value: float
) -> None:
    array = getattr(gallop, name).copy()
    array.flat[array.size // 2] = value
    assert worst(planar.as_data(), replace(gallop, **{name: array}), SPEED, CYCLE, "0110/1100") == math.inf


def test_step_gaps_are_the_distance_to_the_continuous_motion(planar: Scenario, gallop: Trajectory) -> None:
    """Each step integrated anew by an adaptive method, from planar equations written out here."""
    gaps = step_gaps(planar.as_data(), gallop)
    assert gaps.shape == (16, 6)
    slope, inertia = math.radians(20.0), planar.robot.inertia[0][0]
    for k in (0, 5, 9, 15):
        force, feet, speed = gallop.forces[k], gallop.feet[k], gallop.foot_velocities[k]

        def rate(t: float, x: Array, force: Array = force, feet: Array = feet, speed: Array = speed) -> Array:
            lever = feet + t * speed - x[:2]
            turn = (lever[:, 0] * force[:, 1] - lever[:, 1] * force[:, 0]).sum() / inertia
            pull = force.sum(axis=0) / 14.0 - GRAVITY * np.array([math.sin(slope), math.cos(slope)])
            return np.array([*x[3:], *pull, turn])

        h = gallop.times[k + 1] - gallop.times[k]
        end = solve_ivp(rate, (0.0, h), gallop.base[k], rtol=1e-11, atol=1e-13).y[:, -1]
        np.testing.assert_allclose(gaps[k], gallop.base[k + 1] - end, atol=1e-9)
    assert np.abs(gaps).max() > 1e-3  # Euler at 16 steps is not free of it


def test_the_box_holds_at_the_last_knot_too(planar: Scenario, gallop: Trajectory) -> None:
    """The program leaves it to periodicity; the check must not."""
    far = replace(gallop, feet=gallop.feet.copy())
    far.feet[-1, F, 0] += 1.0
    assert violations(planar.as_data(), far, SPEED, CYCLE, "0110/1100")["kinematic box"] > 0.5
