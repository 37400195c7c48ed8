from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from terms import with_axes

from gaitflow.config.scenario import Objective, Scenario, Transcription
from gaitflow.core.gaits import Pattern
from gaitflow.core.task import AXIS_NAMES, Task
from gaitflow.core.trajectory import Array
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.search import starts
from gaitflow.solvers.program import derivatives

SLOPED = Task.of({"speed": 0.8, "cycle_duration": 0.6, "slope": 15.0, "acceleration": 0.3})
TASK = SLOPED.parameters


@pytest.fixture(params=["rk4", "momentum"])
def problem(either: Scenario, request: pytest.FixtureRequest) -> GaitProblem:
    """Every term of the cost and every axis at work, by the most nonlinear step and by the exact one."""
    spatial = either.robot.dimension == 3
    objective = Objective(
        force=1e-3, tangential_velocity=2.0, normal_velocity=3.0, tilt=5.0, tilt_rate=7.0, lateral_foot=4.0 * spatial
    )
    transcription = Transcription(knots_per_phase=3, integrator=request.param, forces="linear", grading=0.7)
    scenario = with_axes(either, acceleration=0.3, **({"lateral_speed": 0.1} if spatial else {}))
    return transcribe(scenario.model_copy(update={"objective": objective, "transcription": transcription}))


def _somewhere(problem: GaitProblem, seed: int = 0) -> Array:
    rng = np.random.default_rng(seed)
    return starts.random(problem.scenario.robot, problem.layout, SLOPED, rng)


def _pattern(problem: GaitProblem) -> Pattern:
    return Pattern(("0110", "1100", "1111", "0000")[: problem.layout.legs])


def test_first_derivatives_match_finite_differences(problem: GaitProblem) -> None:
    w, layout = _somewhere(problem), problem.layout
    symbol = ca.SX.sym("w", layout.nw)
    cost, rows = problem.nlp(symbol, TASK)
    derivatives = ca.Function("first", [symbol], [ca.gradient(cost, symbol), ca.jacobian(rows, symbol)])
    gradient, jacobian = derivatives(w)
    rng, e = np.random.default_rng(1), 1e-5
    for _ in range(5):
        direction = rng.normal(size=layout.nw)
        (cost_up, rows_up), (cost_down, rows_down) = (problem.nlp(w + s * e * direction, TASK) for s in (1, -1))
        assert float(gradient.T @ direction) == pytest.approx(float(cost_up - cost_down) / (2 * e), rel=1e-6)
        numeric = ((rows_up - rows_down) / (2 * e)).full()
        np.testing.assert_allclose((jacobian @ direction).full(), numeric, rtol=1e-6, atol=1e-6)


def test_second_derivatives_match_finite_differences(problem: GaitProblem) -> None:
    """Products of the Lagrangian's Hessian, the one IPOPT asks for, against differences of its gradient."""
    w, layout = _somewhere(problem), problem.layout
    rng, e = np.random.default_rng(2), 1e-5
    multipliers = rng.normal(size=problem.ng)
    symbol = ca.SX.sym("w", layout.nw)
    cost, rows = problem.nlp(symbol, TASK)
    hessian, gradient = ca.hessian(cost + ca.dot(multipliers, rows), symbol)
    second = ca.Function("second", [symbol], [hessian, gradient])
    found = second(w)[0]
    assert abs(found).full().max() > 1e-3
    for _ in range(3):
        direction = rng.normal(size=layout.nw)
        up, down = (second(w + s * e * direction)[1] for s in (1, -1))
        numeric = ((up - down) / (2 * e)).full()
        np.testing.assert_allclose((found @ direction).full(), numeric, rtol=1e-5, atol=1e-5 * np.abs(numeric).max())


def test_the_cost_is_the_euler_sum_of_the_integrand(planar: Scenario) -> None:
    """Eq. (9) written out in numpy on a random trajectory, times the step of each phase."""
    problem = transcribe(planar)
    w = _somewhere(problem)
    trajectory = problem.layout.unpack(w, SLOPED.cycle_duration)
    v_t, v_n, pitch, rate = (trajectory.base[:-1, index] for index in (3, 4, 2, 5))
    expected = np.diff(trajectory.times) @ (1e6 * ((v_t - SLOPED.speed) ** 2 + v_n**2 + pitch**2 + rate**2))
    assert float(problem.nlp(w, TASK)[0]) * problem.cost_scale == pytest.approx(expected)


def test_one_program_serves_every_speed(planar: Scenario) -> None:
    """Speed is a parameter: it moves the periodicity rows, and no bound."""
    problem = transcribe(planar)
    layout, w = problem.layout, _somewhere(problem)
    rows = [problem.nlp(w, SLOPED.replaced(speed=v).parameters)[1].full().ravel() for v in (0.8, 1.8)]
    changed = np.flatnonzero(rows[0] != rows[1])
    closing = problem.ng - 1 - layout.nx
    assert list(changed) == [closing, closing + layout.nb, closing + layout.nb + 2]
    np.testing.assert_allclose(rows[1][changed] - rows[0][changed], -0.6)


def test_every_axis_that_varies_is_a_parameter_and_no_other(anymal: Scenario) -> None:
    """An axis fixed at 0 is no part of the program; any other moves it."""
    turning = with_axes(anymal, yaw_rate={"start": -1.0, "stop": 1.0, "count": 3}, lateral_speed=0.1)
    few = Transcription(knots_per_phase=2, integrator="momentum", forces="linear")
    problem = transcribe(turning.model_copy(update={"transcription": few}))
    w = starts.random(problem.scenario.robot, problem.layout, SLOPED, np.random.default_rng(0))
    task = Task.of({"speed": 0.8, "cycle_duration": 0.6, "yaw_rate": 0.5, "lateral_speed": 0.1})
    before = [part.full().ravel() for part in problem.nlp(w, task.parameters)]
    moved = set()
    for index, axis in enumerate(AXIS_NAMES):
        values = task.parameters
        values[index] += 0.05
        after = [part.full().ravel() for part in problem.nlp(w, values)]
        if any((a != b).any() for a, b in zip(before, after, strict=True)):
            moved.add(axis)
    assert moved == {"speed", "lateral_speed", "yaw_rate", "cycle_duration", "friction"}


def test_a_body_that_turns_may_turn_as_far_as_it_likes(anymal: Scenario) -> None:
    pattern = Pattern.from_text("0110/1001/1001/0110")
    turning = with_axes(anymal, yaw_rate={"start": -1.0, "stop": 1.0, "count": 3})
    for scenario, limited in ((anymal, [0, 1, 2]), (turning, [1, 2])):
        problem = transcribe(scenario)
        bounds, layout = problem.bounds(pattern), problem.layout
        for knot in (0, 17, layout.steps):
            angles = slice(layout.state(knot).start + 3, layout.state(knot).start + 6)
            assert list(np.flatnonzero(np.isfinite(bounds.upper[angles]))) == limited
            assert list(np.flatnonzero(np.isfinite(bounds.lower[angles]))) == limited


@pytest.mark.parametrize("grading", [0.0, 0.7])
def test_steps_have_box_rows_in_their_middle(planar: Scenario, grading: float) -> None:
    exact = Transcription(integrator="momentum", forces="linear", grading=grading)
    euler = Transcription(integrator="euler", grading=grading)
    counts = {
        settings.integrator: transcribe(planar.model_copy(update={"transcription": settings})).ng
        for settings in (exact, euler)
    }
    ends_of_phases = 4 * 2 * 2  # rows of friction: 4 phases, 2 legs, 2 faces
    assert counts["momentum"] - counts["euler"] == 40 * 2 * 2 + ends_of_phases


def test_bounds_fix_contacts_and_never_contradict(problem: GaitProblem) -> None:
    pattern, layout = _pattern(problem), problem.layout
    bounds = problem.bounds(pattern)
    assert (bounds.lower <= bounds.upper).all()
    assert (bounds.lower_rows <= bounds.upper_rows).all()
    assert bounds.lower.shape == (layout.nw,)
    assert bounds.lower_rows.shape == (problem.ng,)
    low, high = layout.unpack(bounds.lower, 1.0), layout.unpack(bounds.upper, 1.0)
    robot = problem.scenario.robot
    for step in range(layout.steps):
        for leg, stands in enumerate(pattern.column(layout.phase_of(step))):
            for end in (low, high):
                fixed = [end.foot_velocities] if stands else [end.forces, end.end_forces]
                assert not any(array[step, leg].any() for array in fixed)
            if stands:
                assert high.feet[step, leg, -1] == high.feet[step + 1, leg, -1] == 0
                assert low.forces[step, leg, -1] == low.end_forces[step, leg, -1] == 0
                assert high.forces[step, leg, -1] == high.end_forces[step, leg, -1] == robot.max_force
            else:
                assert (high.foot_velocities[step, leg] == robot.max_foot_speed).all()
    assert not low.feet[..., -1].any()
    assert (low.base[0, 0], high.base[0, 0]) == (0, 0)


def test_free_rows_are_exactly_the_constant_ones(problem: GaitProblem) -> None:
    """A row is left free when no variable that the solver may move enters it, and held otherwise."""
    pattern = _pattern(problem)
    bounds, layout = problem.bounds(pattern), problem.layout
    symbol = ca.SX.sym("w", layout.nw)
    jacobian = ca.Function("jacobian", [symbol], [ca.jacobian(problem.nlp(symbol, TASK)[1], symbol)])
    point = np.where(bounds.lower == bounds.upper, bounds.lower, _somewhere(problem))
    movable = np.abs(jacobian(point).full()[:, bounds.lower < bounds.upper]).max(axis=1) > 0
    free = np.isinf(bounds.lower_rows) & np.isinf(bounds.upper_rows)
    np.testing.assert_array_equal(free, ~movable)
    values = problem.nlp(point, TASK)[1].full().ravel()
    np.testing.assert_array_equal(values[free], 0.0)  # what is left free holds by itself


@pytest.mark.parametrize("text", ["0110", "011/110", "0110/1100/0011", "0110/1100/0011/1001/1111"])
def test_a_pattern_of_another_shape_is_refused(planar: Scenario, text: str) -> None:
    with pytest.raises(ValueError, match=r"the scenario has 2 and 4"):
        transcribe(planar).bounds(Pattern.from_text(text))


def test_the_path_starts_at_the_origin_and_only_where_that_is_free(anymal: Scenario) -> None:
    """Sideways the lateral term says where the path lies; without it the start is fixed there too."""
    pattern = Pattern.from_text("0110/1001/1001/0110")
    plain = anymal.model_copy(update={"objective": Objective(force=1.0)})
    for scenario, fixed in ((anymal, [0]), (plain, [0, 1])):
        bounds = transcribe(scenario).bounds(pattern)
        assert list(np.flatnonzero(bounds.lower[:3] == bounds.upper[:3])) == fixed


@pytest.mark.parametrize("forces", ["held", "linear"])
def test_minlp_rows_extend_those_of_the_nlp(either: Scenario, forces: str) -> None:
    transcription = either.transcription.model_copy(update={"forces": forces})
    problem = transcribe(either.model_copy(update={"stances_per_leg": 1, "transcription": transcription}))
    layout, w = problem.layout, _somewhere(problem)
    pattern = Pattern(("0110", "1100", "1110", "0001")[: layout.legs])
    contacts = np.array([float(digit) for row in pattern.rows for digit in row])
    (cost, rows), (own_cost, own_rows) = problem.nlp(w, TASK), problem.minlp(np.append(w, contacts), TASK)
    assert float(cost) == float(own_cost)
    np.testing.assert_array_equal(rows.full(), own_rows[: problem.ng].full())
    bounds = problem.minlp_bounds(pattern)
    assert bounds.lower_rows.shape == bounds.upper_rows.shape == (own_rows.numel(),)
    np.testing.assert_array_equal(bounds.lower[layout.nw :], contacts)
    np.testing.assert_array_equal(bounds.upper[layout.nw :], contacts)
    free = problem.minlp_bounds()
    assert set(free.lower[layout.nw :]) == {0.0}
    assert set(free.upper[layout.nw :]) == {1.0}
    stance_rows = 2 * layout.legs  # a count, and the one choice of four phases out of four
    tail = own_rows.full().ravel()[-stance_rows:]
    assert (tail >= bounds.lower_rows[-stance_rows:]).all()
    assert (tail <= bounds.upper_rows[-stance_rows:]).all()


def test_equal_problems_share_their_program_and_its_derivatives(planar: Scenario) -> None:
    faster = with_axes(planar, speed={"start": 0.5, "stop": 1.5, "count": 3})
    named = planar.model_copy(update={"name": "another"})
    heavier = planar.model_copy(update={"robot": planar.robot.model_copy(update={"mass": 15.0})})
    own, *others, different = (transcribe(each) for each in (planar, faster, named, heavier))
    assert [other.scenario for other in others] == [faster, named], "each with its own ranges and name"
    assert all(other.separable is own.separable and other.nlp is own.nlp for other in others)
    assert derivatives(own.separable) is derivatives(others[0].separable)
    assert different.separable is not own.separable
