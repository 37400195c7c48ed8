from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitflow.core.domain import Domain
from gaitflow.core.task import Task

SPEEDS, DURATIONS = (0.1, 0.5, 0.9, 2.1), (0.4, 0.6, 1.2)
AXES = {"speed": SPEEDS, "cycle_duration": DURATIONS}
# The grid task (0.9, 0.6) has no feasible gait.
DOMAIN = Domain(AXES, np.array([[(v, t) != (0.9, 0.6) for t in DURATIONS] for v in SPEEDS]))
WHOLE = Domain(AXES, np.ones((4, 3), dtype=bool))


def task(speed: float, duration: float) -> dict[str, float]:
    return {"speed": speed, "cycle_duration": duration}


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
    assert DOMAIN.contains(task(speed, duration)) is inside


def test_a_whole_task_may_be_asked_for() -> None:
    assert DOMAIN.contains(Task.of({**task(0.3, 0.5), "slope": 10.0}))
    assert not DOMAIN.contains(Task.of(task(0.7, 0.5)))


@pytest.mark.parametrize("axis", ["speed", "slope"])
def test_one_axis_is_enough(axis: str) -> None:
    line = Domain({axis: (1.0, 2.0, 4.0, 5.0)}, np.array([True, True, True, False]))
    assert [line.contains({axis: x}) for x in (0.9, 1.0, 1.5, 3.9, 4.0, 4.5, 5.0)] == [0, 1, 1, 1, 1, 0, 0]
    asked = np.array([0.9, 1.0, 1.5, 3.9, 4.0, 4.5, 5.0])
    assert line.contains_many({axis: asked}).tolist() == [line.contains({axis: x}) for x in asked]
    assert line.distance({axis: 4.5}) == pytest.approx(0.5 / (4 / 3))
    assert line.middle == {axis: 2.0}
    assert line.explain({axis: 4.5}).startswith("task (4.5 ")


def test_three_axes_need_all_eight_corners() -> None:
    feasible = np.ones((3, 3, 3), dtype=bool)
    feasible[1, 1, 2] = False
    cube = Domain({**AXES, "speed": (0.0, 1.0, 2.0), "slope": (-20.0, 0.0, 20.0)}, feasible)
    inside = {
        (v, t, s): cube.contains({**task(v, t), "slope": s})
        for v, t, s in product((0.5, 1.5), (0.5, 0.9), (-10.0, 10.0))
    }
    assert inside == {place: place[2] < 0 for place in inside}, "every upper cell touches the infeasible task"
    assert cube.contains({**task(1.0, 0.6), "slope": 0.0})
    assert not cube.contains({**task(1.0, 0.6), "slope": 1.0})
    assert cube.explain({**task(0.5, 0.5), "slope": 10.0}) == (
        "task (0.5 m/s, 0.5 s, 10 deg) lies at grid tasks without a feasible gait: (1 m/s, 0.6 s, 20 deg)"
    )
    assert cube.explain({**task(0.5, 0.5), "slope": 25.0}) == "slope = 25 deg is outside the map's -20 deg to 20 deg"
    assert cube.middle == {"speed": 1.0, "cycle_duration": 0.6, "slope": 0.0}


def test_a_grid_of_one_task_contains_that_task_only() -> None:
    one = Domain({"speed": (0.5,), "cycle_duration": (0.8,)}, np.array([[True]]))
    assert one.contains(task(0.5, 0.8))
    assert not one.contains(task(0.5, 0.81))
    asked = {"speed": np.array([0.5, 0.4]), "cycle_duration": np.array([0.8, 0.8])}
    assert one.contains_many(asked).tolist() == [True, False]


near = st.sampled_from([*SPEEDS, *DURATIONS]).flatmap(lambda x: st.sampled_from([x, x + 1e-12, x - 1e-12, x + 1e-7]))
number = st.one_of(near, st.floats(-1, 3), st.floats(allow_nan=False, allow_infinity=False))


@given(st.lists(st.tuples(number, number), min_size=1, max_size=30))
def test_many_agree_with_one_by_one(tasks: list[tuple[float, float]]) -> None:
    v, t = np.array(tasks).T
    for domain in (DOMAIN, WHOLE):
        many = domain.contains_many({"speed": v, "cycle_duration": t})
        assert many.tolist() == [domain.contains(task(*one)) for one in tasks]


@given(st.floats(0.1, 2.1), st.floats(0.4, 1.2))
def test_everything_within_a_feasible_grid_is_inside(speed: float, duration: float) -> None:
    assert WHOLE.contains(task(speed, duration))


@given(st.floats(0.1, 2.1), st.floats(0.4, 1.2))
def test_what_is_not_inside_is_explained_by_an_infeasible_task(speed: float, duration: float) -> None:
    if not DOMAIN.contains(task(speed, duration)):
        assert "(0.9 m/s, 0.6 s)" in DOMAIN.explain(task(speed, duration))


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
    assert DOMAIN.distance(task(speed, duration)) == pytest.approx(steps, abs=1e-12)


@given(st.floats(0.1, 2.1), st.floats(0.4, 1.2))
def test_no_task_of_an_even_grid_is_further_than_half_its_cells_diagonal(speed: float, duration: float) -> None:
    even = Domain({"speed": (0.1, 1.1, 2.1), "cycle_duration": (0.4, 0.8, 1.2)}, np.ones((3, 3), dtype=bool))
    assert even.distance(task(speed, duration)) <= 0.5**0.5 + 1e-9


def test_distance_where_there_is_no_step_or_no_task() -> None:
    axes = {"speed": (0.5,), "cycle_duration": (0.8,)}
    one, none = Domain(axes, np.array([[True]])), Domain(axes, np.array([[False]]))
    assert one.distance(task(1.5, 0.8)) == pytest.approx(1.0), "an axis of one value counts in its unit"
    assert none.distance(task(0.5, 0.8)) == np.inf
    with pytest.raises(ValueError, match="no task with a feasible gait"):
        none.middle  # noqa: B018


def test_the_middle_is_a_task_that_the_map_answers_for() -> None:
    assert DOMAIN.contains(DOMAIN.middle)
    assert DOMAIN.middle != task(0.9, 0.6)


@pytest.mark.filterwarnings("error")
def test_distance_to_the_end_of_the_world_is_no_accident() -> None:
    assert DOMAIN.distance(task(1e300, 0.6)) > 1e299
    assert DOMAIN.distance(task(-1.7e308, 1.7e308)) == np.inf


def test_beyond_the_grid_is_explained_by_value_and_range() -> None:
    assert DOMAIN.explain(task(3.0, 0.6)) == "speed = 3 m/s is outside the map's 0.1 m/s to 2.1 m/s"
    assert DOMAIN.explain(task(0.5, 0.2)) == "cycle_duration = 0.2 s is outside the map's 0.4 s to 1.2 s"


@pytest.mark.parametrize(
    ("axes", "feasible", "match"),
    [
        ({"speed": (0.1, 0.1)}, np.ones(2, dtype=bool), "rising"),
        ({"speed": ()}, np.ones(0, dtype=bool), "rising"),
        ({"height": (0.1,)}, np.ones(1, dtype=bool), "must be one of speed"),
        ({"speed": (0.1, 0.2)}, np.ones(3, dtype=bool), r"expected bool \(2,\)"),
        ({"speed": (0.1, 0.2)}, np.ones(2), "expected bool"),
        ({}, np.array(True), "expected bool"),
    ],
)
def test_what_is_no_grid_is_refused(axes: dict, feasible: np.ndarray, match: str) -> None:
    with pytest.raises(ValueError, match=match):
        Domain(axes, feasible)
