"""The bounds are exact, and all askings together have the stated chance of error."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom

from gaitflow.certificate.bound import (
    ALLOWED,
    CONFIDENCE,
    chance_of,
    chances_of,
    has_hope,
    tasks_needed,
    tasks_of_look,
    upper_bound,
)


def at_most(failures: int, tasks: int, share: float) -> float:
    """The probability of so few failures, summed term by term."""
    return sum(math.comb(tasks, k) * share**k * (1 - share) ** (tasks - k) for k in range(failures + 1))


@given(st.integers(1, 120), st.floats(1e-3, 0.5), st.data())
def test_at_the_bound_so_few_failures_have_just_the_stated_chance(
    tasks: int, chance: float, data: st.DataObject
) -> None:
    failures = data.draw(st.integers(0, tasks - 1))
    bound = upper_bound(failures, tasks, chance)
    assert at_most(failures, tasks, bound) == pytest.approx(chance, rel=1e-6)


def test_a_sample_without_a_success_bounds_nothing() -> None:
    assert upper_bound(3, 3, 0.05) == 1.0


@pytest.mark.parametrize(("failures", "tasks", "chance"), [(-1, 5, 0.1), (6, 5, 0.1), (1, 5, 0.0), (1, 5, 1.0)])
def test_a_sample_that_cannot_be_is_refused(failures: int, tasks: int, chance: float) -> None:
    with pytest.raises(ValueError, match=f"{failures} failures of {tasks} tasks"):
        upper_bound(failures, tasks, chance)


@given(st.integers(0, 5), st.floats(0.005, 0.3), st.floats(1e-3, 0.3))
def test_no_fewer_tasks_would_do(failures: int, share: float, chance: float) -> None:
    tasks = tasks_needed(failures, share, chance)
    assert upper_bound(failures, tasks, chance) <= share < upper_bound(failures, tasks - 1, chance)


def test_the_rule_of_three() -> None:
    assert tasks_needed(0, 0.02, 0.05) == 149, "(1 - 0.02)^149 < 0.05"


def test_a_share_that_nobody_could_show_is_refused() -> None:
    with pytest.raises(ValueError, match="takes more than"):
        tasks_needed(0, 1e-9, 0.05)


def test_all_askings_together_have_the_whole_chance_of_error_and_no_more() -> None:
    assert sum(map(chance_of, range(1, 100_000))) == pytest.approx(1 - CONFIDENCE, rel=1e-4)
    assert sum(map(chance_of, range(1, 100_000))) < 1 - CONFIDENCE
    for asking in range(1, 6):
        assert sum(chances_of(asking)) == pytest.approx(chance_of(asking))


def wrong_claims(share: float, earlier: int) -> float:
    """How often a map of which just `share` fails is claimed to be better, at any look; computed exactly."""
    wrong, before, tried = 0.0, 0, {0: 1.0}
    for look in range(len(ALLOWED)):
        asking = earlier + look + 1
        tasks, after = tasks_of_look(look, share, asking), dict[int, float]()
        assert tasks > before
        for failed, weight in tried.items():
            for further in range(min(tasks - before, ALLOWED[-1] - failed) + 1):
                probability = weight * float(binom.pmf(further, tasks - before, share))
                failures = failed + further
                if upper_bound(failures, tasks, chances_of(asking)[0]) <= share:
                    wrong += probability
                elif has_hope(failures, tasks, look, share):
                    after[failures] = after.get(failures, 0.0) + probability
        tried, before = after, tasks
    return wrong


@pytest.mark.parametrize("earlier", [0, 1, 3])
@pytest.mark.parametrize("share", [0.01, 0.02, 0.05, 0.2])
def test_a_map_that_misses_its_goal_is_seldom_certified(share: float, earlier: int) -> None:
    spent = sum(chances_of(earlier + look + 1)[0] for look in range(len(ALLOWED)))
    assert 0.3 * spent < wrong_claims(share, earlier) <= spent


def test_more_tasks_are_tried_where_there_is_hope() -> None:
    assert has_hope(2, 184, 0, 0.02), "two of 184 failed"
    assert not has_hope(4, 184, 0, 0.02), "more than half of what the goal allows"
    assert has_hope(5, 700, 2, 0.02), "as many of more tasks are few"
    assert not has_hope(3, 1166, 3, 0.02), "there is no further look"
