from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitflow.core.domain import Domain

SPEEDS, DURATIONS = (0.1, 0.5, 0.9, 2.1), (0.4, 0.6, 1.2)
# The grid task (0.9, 0.6) has no feasible gait.
DOMAIN = Domain(SPEEDS, DURATIONS, tuple(tuple((v, t) != (0.9, 0.6) for t in DURATIONS) for v in SPEEDS))
WHOLE = Domain(SPEEDS, DURATIONS, ((True,) * 3,) * 4)


@pytest.mark.parametrize(
    ("speed", "duration", "inside"),
    [
        (0.1, 0.4, True),  # the corners of the grid belong to it
        (2.1, 1.2, True),
        (0.3, 0.5, True),  # in a cell of four feasible tasks
        (0.7, 0.5, False),  # in a cell with an infeasible corner
        (1.5, 0.7, False),
        (0.9, 0.6, False),  # the infeasible task itself
        (0.9, 0.4, True),  # a feasible task whose neighbour is not
        (0.5, 0.6, True),
        (0.9, 0.5, False),  # on a grid line that ends in the infeasible task
        (0.7, 0.6, False),
        (0.7, 0.4, True),  # on a line between feasible tasks
        (0.3, 0.6, True),
        (0.1 - 1e-6, 0.6, False),
        (2.1 + 1e-6, 0.6, False),
        (0.3, 0.4 - 1e-6, False),
        (0.3, 1.2 + 1e-6, False),
        (0.1 + 0.4 - 1e-12, 0.6, True),  # rounding does not push a task off its grid line
        (-1.0, 0.6, False),
        (1e300, 1e300, False),
    ],
)
def test_inside_is_between_feasible_tasks(speed: float, duration: float, inside: bool) -> None:
    assert DOMAIN.contains(speed, duration) is inside


def test_a_grid_of_one_task_contains_that_task_only() -> None:
    one = Domain((0.5,), (0.8,), ((True,),))
    assert one.contains(0.5, 0.8)
    assert not one.contains(0.5, 0.81)
    assert one.contains_many(np.array([0.5, 0.4]), np.array([0.8, 0.8])).tolist() == [True, False]


near = st.sampled_from([*SPEEDS, *DURATIONS]).flatmap(lambda x: st.sampled_from([x, x + 1e-12, x - 1e-12, x + 1e-7]))
number = st.one_of(near, st.floats(-1, 3), st.floats(allow_nan=False, allow_infinity=False))


@given(st.lists(st.tuples(number, number), min_size=1, max_size=30))
def test_many_agree_with_one_by_one(tasks: list[tuple[float, float]]) -> None:
    v, t = np.array(tasks).T
    for domain in (DOMAIN, WHOLE):
        assert domain.contains_many(v, t).tolist() == [domain.contains(*task) for task in tasks]


@given(st.floats(0.1, 2.1), st.floats(0.4, 1.2))
def test_everything_within_a_feasible_grid_is_inside(speed: float, duration: float) -> None:
    assert WHOLE.contains(speed, duration)


@given(st.floats(0.1, 2.1), st.floats(0.4, 1.2))
def test_what_is_not_inside_is_explained_by_an_infeasible_task(speed: float, duration: float) -> None:
    if not DOMAIN.contains(speed, duration):
        assert "(0.9 m/s, 0.6 s)" in DOMAIN.explain(speed, duration)


@pytest.mark.parametrize(
    ("speed", "duration", "steps"),
    [
        (0.1, 0.4, 0.0),
        (0.1, 0.8, 0.5),  # the steps are the axes' means, 2/3 m/s and 0.4 s
        (0.9, 0.6, 0.5),  # an infeasible task is none that was trained on
        (2.1 + 2 / 3, 1.2, 1.0),
        (2.1 + 2.0, 1.2 + 1.6, 5.0),
        (-0.1, 0.4, 0.3),
    ],
)
def test_distance_is_to_the_nearest_feasible_task_in_steps(speed: float, duration: float, steps: float) -> None:
    assert DOMAIN.distance(speed, duration) == pytest.approx(steps, abs=1e-12)


@given(st.floats(0.1, 2.1), st.floats(0.4, 1.2))
def test_no_task_of_an_even_grid_is_further_than_half_its_cells_diagonal(speed: float, duration: float) -> None:
    even = Domain((0.1, 1.1, 2.1), (0.4, 0.8, 1.2), ((True,) * 3,) * 3)
    assert even.distance(speed, duration) <= 0.5**0.5 + 1e-9


def test_distance_where_there_is_no_step_or_no_task() -> None:
    one = Domain((0.5,), (0.8,), ((True,),))
    assert one.distance(1.5, 0.8) == pytest.approx(1.0), "an axis of one value counts in its unit"
    assert Domain((0.5,), (0.8,), ((False,),)).distance(0.5, 0.8) == np.inf


@pytest.mark.filterwarnings("error")
def test_distance_to_the_end_of_the_world_is_no_accident() -> None:
    assert DOMAIN.distance(1e300, 0.6) > 1e299
    assert DOMAIN.distance(-1.7e308, 1.7e308) == np.inf


def test_beyond_the_grid_is_explained_by_value_and_range() -> None:
    assert DOMAIN.explain(3.0, 0.6) == "speed = 3 m/s is outside the map's 0.1 to 2.1 m/s"
    assert DOMAIN.explain(0.5, 0.2) == "cycle_duration = 0.2 s is outside the map's 0.4 to 1.2 s"
