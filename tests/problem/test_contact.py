from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.problem.contact import fix_contacts, highest_lift, middles_of_swings, one_stance_rows
from gaitflow.search import starts

TASK = Task.of({"speed": 1.0, "cycle_duration": 0.6, "slope": 15.0})


@pytest.mark.parametrize("phases", [2, 3, 4, 5, 6, 7])
def test_one_stance_rows_admit_exactly_the_patterns_with_one_touchdown(phases: int) -> None:
    rows, lower, upper = one_stance_rows(1, phases)
    for digits in product("01", repeat=phases):
        found = rows @ np.array(digits, dtype=float)
        admitted = bool((found >= lower).all() and (found <= upper).all())
        assert admitted == (Pattern(("".join(digits),)).touchdowns(0) == 1), digits


def test_one_stance_rows_treat_legs_apart() -> None:
    rows, lower, upper = one_stance_rows(2, 4)
    single = one_stance_rows(1, 4)
    assert len(rows) == len(lower) == len(upper) == 2 * len(single[0])
    np.testing.assert_array_equal(rows, np.kron(np.eye(2), single[0]))


@pytest.mark.parametrize("forces", ["held", "linear"])
def test_contacts_fix_what_eq_7_says_and_nothing_else(either: Scenario, forces: str) -> None:
    transcription = either.transcription.model_copy(update={"forces": forces})
    problem = transcribe(either.model_copy(update={"transcription": transcription}))
    layout = problem.layout
    pattern = Pattern(("0110", "1000", "1111", "0000")[: layout.legs])
    lower, upper = np.full(layout.nw, -np.inf), np.full(layout.nw, np.inf)
    fix_contacts(layout, pattern, lower, upper)
    fixed = np.zeros(layout.nw)
    fixed[lower == upper] = 1
    assert not lower[lower == upper].any()
    assert np.isinf(lower[lower != upper]).all()
    trajectory = layout.unpack(fixed / layout.scale(1.0), 1.0)  # ones where a variable is fixed
    n = layout.knots_per_phase
    for leg, row in enumerate(pattern.rows):
        stands = np.repeat([digit == "1" for digit in row], n)
        on_ground = np.append(stands, False) | np.append(False, stands)  # both ends of each stance step
        on_ground[[0, -1]] = on_ground[0] or on_ground[-1]  # one place of the cycle
        assert (trajectory.forces[:, leg] == ~stands[:, None]).all()
        assert (trajectory.end_forces[:, leg] == ~stands[:, None]).all()
        assert (trajectory.foot_velocities[:, leg] == stands[:, None]).all()
        assert (trajectory.feet[:, leg, -1] == on_ground).all()
        assert not trajectory.feet[:, leg, :-1].any()
    assert not trajectory.base.any()
    assert not trajectory.durations.any()


@pytest.mark.parametrize(
    ("row", "knots", "middles"),
    [
        ("0110", 10, [0, 40]),  # over the cycle's end, which is a knot twice
        ("1110", 10, [35]),
        ("0111", 10, [5]),
        ("1100", 10, [30]),
        ("0011", 10, [10]),
        ("0001", 10, [15]),
        ("1000", 10, [25]),
        ("0100", 10, [35]),  # phases 2, 3 and 0
        ("1010", 10, [15, 35]),
        ("1010", 4, [6, 14]),
        ("1110", 5, [17, 18]),  # a swing of an odd number of steps has two knots in its middle
        ("0100", 5, [17, 18]),
        ("1001", 5, [10]),
        ("0110", 5, [0, 20]),
        ("10010", 3, [6, 13, 14]),
        ("01101110", 2, [0, 7, 16]),
        ("1111", 10, []),
        ("0000", 10, []),  # never begins
    ],
)
def test_middles_of_swings(row: str, knots: int, middles: list[int]) -> None:
    assert middles_of_swings(row, knots) == middles


@pytest.mark.parametrize("knots", [2, 3, 10])
def test_middles_turn_with_the_cycle(knots: int) -> None:
    steps = 4 * knots
    for digits in product("01", repeat=4):
        row = "".join(digits)
        found = {middle % steps for middle in middles_of_swings(row, knots)}
        turned = {middle % steps for middle in middles_of_swings(row[1:] + row[0], knots)}
        assert turned == {(middle - knots) % steps for middle in found}, row


def test_clearance_lifts_the_middles_of_swings_and_nothing_else(either: Scenario) -> None:
    layout = transcribe(either).layout
    pattern = Pattern(("0110", "1000", "1111", "0000")[: layout.legs])
    flat, high = (np.full(layout.nw, -np.inf) for _ in range(2))
    tops = [np.full(layout.nw, np.inf) for _ in range(2)]
    fix_contacts(layout, pattern, flat, tops[0])
    fix_contacts(layout, pattern, high, tops[1], 0.05)
    np.testing.assert_array_equal(*tops)
    n = layout.knots_per_phase
    middles = [(0, 0), (4 * n, 0), (2 * n + n // 2, 1), (2 * n + (n + 1) // 2, 1)]
    expected = flat.copy()
    expected[[layout.foot(knot, leg).stop - 1 for knot, leg in middles]] = 0.05
    np.testing.assert_array_equal(high, expected)


def _walking_like(problem: GaitProblem, pattern: Pattern) -> Array:
    """A point w within the physical bounds whose contacts are exactly those of the pattern; not a motion."""
    layout = problem.layout
    w = starts.nominal(problem.scenario.robot, layout, TASK)
    for step in range(layout.steps):
        for leg, stands in enumerate(pattern.column(layout.phase_of(step))):
            w[layout.foot_velocity(step, leg) if stands else layout.force(step, leg)] = 0.0
            w[layout.foot(step, leg).stop - 1] = 0.0 if stands else 0.1
    return w


def test_big_m_rows_and_bounds_switch_the_same_conditions(either: Scenario) -> None:
    """A point passes the big-M rows of exactly those patterns whose fixed variables it has at zero."""
    problem = transcribe(either)
    layout = problem.layout
    true = Pattern(("0110", "1100", "0011", "1001")[: layout.legs])
    w = _walking_like(problem, true)
    rng = np.random.default_rng(0)
    others = ["".join(rng.choice(["0", "1"], 4)) for _ in range(60 * layout.legs)]
    patterns = [true] + [Pattern(tuple(others[i : i + layout.legs])) for i in range(0, len(others), layout.legs)]
    patterns += [
        Pattern((*true.rows[:leg], row, *true.rows[leg + 1 :])) for leg in range(layout.legs) for row in others
    ]
    big_m = slice(problem.ng, problem.ng + layout.steps * layout.legs * (2 * layout.dimension + 2))
    passed = set()
    for pattern in patterns:
        contacts = [float(digit) for row in pattern.rows for digit in row]
        rows = problem.minlp(np.append(w, contacts), TASK.parameters)[1].full().ravel()[big_m]
        lower, upper = np.full(layout.nw, -np.inf), np.full(layout.nw, np.inf)
        fix_contacts(layout, pattern, lower, upper)
        # A stance's last knot belongs to the next phase: there the foot's velocity, not a row, keeps it down.
        for leg, knot in product(range(layout.legs), range(0, layout.steps + 1, layout.knots_per_phase)):
            if knot == layout.steps or not pattern.column(layout.phase_of(knot))[leg]:
                height = layout.foot(knot, leg).stop - 1
                lower[height], upper[height] = -np.inf, np.inf
        bounded = bool(((w >= lower) & (w <= upper)).all())
        assert bounded == bool((rows <= 1e-12).all()), pattern.text
        passed.add(bounded)
    assert passed == {True, False}


@pytest.mark.parametrize("stands", [0, 1])
def test_big_m_rows_cut_nothing_off_that_the_pattern_allows(either: Scenario, stands: int) -> None:
    """At the largest forces in stance, and at the highest feet and fastest velocities in swing, rows still hold."""
    problem = transcribe(either)
    layout = problem.layout
    bounds = problem.minlp_bounds()
    for limit in (bounds.lower, bounds.upper):
        w = np.append(np.where(np.isfinite(limit[: layout.nw]), limit[: layout.nw], 0.0), [stands] * 4 * layout.legs)
        rows = problem.minlp(w, TASK.parameters)[1].full().ravel()
        width = 2 * layout.dimension + 2
        big_m = rows[problem.ng : problem.ng + layout.steps * layout.legs * width].reshape(-1, width)
        assert (big_m[:, :1] if stands else big_m[:, 1:]).max() <= 1e-12


def test_feet_may_be_lifted_by_the_longest_leg(anymal: Scenario) -> None:
    assert highest_lift(anymal.robot) == pytest.approx(0.458 + 0.04)
