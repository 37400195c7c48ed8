from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from sheets import AXES, STEPS, Values, atlas, grid, sheet, sheet_of
from tiny_map import TinyMap

from gaitflow.atlas.grow import Growth
from gaitflow.runtime.atlas import (
    DOUBT,
    HARDLY,
    HARDLY_TRIED,
    MOST_BELOW,
    MOST_OFF,
    NEAR_AXES,
    SUPPORT,
    TRIED,
    Atlas,
    Sheet,
)
from gaitflow.runtime.nearby import REACH

inner = st.tuples(st.floats(1.0, 3.0), st.floats(1.0, 3.0))
coefficients = st.lists(st.floats(-2, 2), min_size=6, max_size=6)


def quadratic(c: list[float]) -> Values:
    """A quadratic of the place in steps and its gradient per step."""

    def value(x: float, y: float) -> float:
        return c[0] + c[1] * x + c[2] * y + 0.1 * (c[3] * x * x + c[4] * x * y + c[5] * y * y)

    def gradient(x: float, y: float) -> tuple[float, float]:
        return c[1] + 0.1 * (2 * c[3] * x + c[4] * y), c[2] + 0.1 * (c[4] * x + 2 * c[5] * y)

    return value, gradient


def predicted(made: Atlas, x: float, y: float, number: int = 0) -> tuple[float, float]:
    """The cost's logarithm and the first coordinate that are predicted at a place in steps."""
    place = np.array([x, y]) * STEPS
    found, one = made.predict(number, place), made.sheets[number]
    return float(np.log(found.cost)), float((found.point - one.mean) @ np.linalg.pinv(one.modes.astype(float))[:, 0])


def test_at_a_node_the_prediction_is_the_node() -> None:
    value, gradient = quadratic([1, 2, 3, 4, 5, 6])
    made = atlas(sheet_of(value, gradient))
    for x, y in grid():
        assert predicted(made, x, y) == pytest.approx((value(x, y), value(x, y)), rel=1e-4, abs=1e-4)
        costs, support = made.costs(np.array([x, y]) * STEPS)
        assert np.log(costs[0]) == pytest.approx(value(x, y), rel=1e-6)
        assert support[0] == pytest.approx(1.0, abs=1e-6)


@given(inner, coefficients)
def test_what_is_linear_is_predicted_exactly(place: tuple[float, float], c: list[float]) -> None:
    value, gradient = quadratic([*c[:3], 0, 0, 0])
    made = atlas(sheet_of(value, gradient))
    assert predicted(made, *place) == pytest.approx((value(*place),) * 2, rel=1e-4, abs=1e-4)
    assert np.log(made.costs(np.array(place) * STEPS)[0][0]) == pytest.approx(value(*place), abs=1e-6)


@given(coefficients)
def test_amid_nodes_what_is_quadratic_is_predicted_nearly_exactly(c: list[float]) -> None:
    value, gradient = quadratic(c)
    made = atlas(sheet_of(value, gradient))
    bend = 0.1 * (abs(c[3]) + abs(c[4]) / 2 + abs(c[5]))
    for place in ((1.5, 1.5), (2.5, 2.5), (2.0, 1.5)):  # whose nodes' centre they are
        assert predicted(made, *place) == pytest.approx((value(*place),) * 2, rel=1e-4, abs=0.08 * bend + 1e-4)


@given(inner)
def test_a_node_at_a_cliff_does_not_decide_beside_it(place: tuple[float, float]) -> None:
    """Its slope is that of its own place: half a step along it the cost would be a twenty-thousandth."""
    assume(np.hypot(place[0] - 2, place[1] - 2) >= 0.4)
    value, gradient = quadratic([1, 0.2, 0.1, 0, 0, 0])
    one = sheet_of(value, gradient)
    slopes = one.slopes.copy()
    slopes[12] *= 100.0  # (2, 2)
    off = np.log(atlas(replace(one, slopes=slopes)).costs(np.array(place) * STEPS)[0][0]) - value(*place)
    assert abs(off) <= 0.1


def test_a_node_of_another_motion_does_not_decide_beside_it() -> None:
    value, gradient = quadratic([1, 0.2, 0.1, 0, 0, 0])
    one = sheet_of(value, gradient)
    costs = one.costs.copy()
    costs[12] *= 3.0
    made = atlas(replace(one, costs=costs))
    assert np.log(made.costs(np.array([2.5, 2.5]) * STEPS)[0][0]) == pytest.approx(value(2.5, 2.5), abs=0.02)
    assert np.log(made.costs(np.array([2.0, 2.0]) * STEPS)[0][0]) == pytest.approx(value(2, 2) + np.log(3), abs=1e-3)


@given(inner, coefficients)
def test_elsewhere_it_is_nearer_than_the_nearest_nodes_tangent_is_at_worst(
    place: tuple[float, float], c: list[float]
) -> None:
    value, gradient = quadratic(c)
    made = atlas(sheet_of(value, gradient))
    bend = 0.1 * (abs(c[3]) + abs(c[4]) / 2 + abs(c[5]))
    assert abs(predicted(made, *place)[0] - value(*place)) <= 0.2 * bend + 1e-6


def test_one_node_answers_by_its_tangent_as_far_as_it_reaches() -> None:
    value, gradient = quadratic([1, 2, 3, 0, 0, 0])
    made = atlas(sheet_of(value, gradient, places=[(2, 2)]))
    assert predicted(made, 2.0, 2.9) == pytest.approx((value(2.0, 2.9),) * 2, rel=1e-4)
    assert made.predict(0, np.array([2.0, 2.0 + REACH + 1e-6]) * STEPS) is None
    costs, support = made.costs(np.array([2.0, 2.0 + REACH + 1e-6]) * STEPS)
    assert np.isnan(costs[0]) and support[0] == 0


def along_one_axis(axes: int, tasks: Sequence[float], slope: float) -> Sheet:
    """A sheet over any number of axes; its cost's logarithm and its first coordinate are `slope` steps of the first."""
    places = np.zeros((len(tasks), axes))
    places[:, 0] = tasks
    tangents = np.zeros((len(tasks), axes, 2))
    tangents[:, 0, 0] = slope
    coordinates = np.column_stack([places[:, 0] * slope, np.zeros(len(tasks))])
    return sheet(places, np.exp(places[:, 0] * slope), tangents[:, :, 0], coordinates, tangents)


def over(axes: int, *sheets: Sheet) -> Atlas:
    return Atlas(tuple(f"axis {n}" for n in range(axes)), np.ones(axes), 1e-4, sheets)


@pytest.mark.parametrize(
    ("axes", "chances", "first"),
    [
        (NEAR_AXES, [0.1, 0.9], 0),
        (NEAR_AXES + 1, None, 0),
        (NEAR_AXES + 1, [0.5, 0.5], 0),
        (NEAR_AXES + 1, [0.4, 0.6], 1),
        (NEAR_AXES + 1, [0.0, 0.0], 0),
    ],
)
def test_over_many_axes_a_cost_counts_over_the_probability_of_its_gait(
    axes: int, chances: list[float] | None, first: int
) -> None:
    places, nothing = np.array(list(product((0.0, 1.0), repeat=axes))), np.zeros((2**axes, axes))
    made = over(
        axes, *(sheet(places, np.full(len(places), cost), nothing, gait=n) for n, cost in enumerate((1.0, 1.3)))
    )
    assert made.ranked(np.full(axes, 0.5), chances) == made.by_cost(np.full(axes, 0.5), chances) == [first, 1 - first]


@pytest.mark.parametrize(("axes", "alike"), [(NEAR_AXES, 0.0), (NEAR_AXES + 1, 1e-6)])
def test_over_many_axes_the_first_of_costs_that_are_alike_comes_first(axes: int, alike: float) -> None:
    places, nothing = np.array(list(product((0.0, 1.0), repeat=axes))), np.zeros((2**axes, axes))
    for less in (alike, 1e-2):
        costs = (1.0, 1.0 - less)
        made = over(axes, *(sheet(places, np.full(len(places), cost), nothing, gait=n) for n, cost in enumerate(costs)))
        assert made.by_cost(np.full(axes, 0.5), [0.5, 0.5]) == ([0, 1] if less == alike else [1, 0])


@pytest.mark.parametrize(("chances", "first"), [(None, 1), ([0.5, 0.5], 0)])
def test_over_many_axes_half_of_the_support_will_do_where_probabilities_are_known(
    chances: list[float] | None, first: int
) -> None:
    axes = NEAR_AXES + 1
    places, far, nothing = np.zeros((1, axes)), np.eye(axes)[:1] * 0.6, np.zeros((1, axes))
    made = over(axes, sheet(far, np.ones(1), nothing, gait=0), sheet(places, np.full(1, 1.3), nothing, gait=1))
    _, support = made.costs(places[0])
    assert TRIED < support[0] < SUPPORT < support[1]
    assert made.ranked(places[0], chances)[0] == first


@pytest.mark.parametrize("steep", [-8.0, 8.0])
@pytest.mark.parametrize(("axes", "off"), [(NEAR_AXES, np.inf), (NEAR_AXES + 1, MOST_OFF)])
def test_over_many_axes_a_start_s_cost_is_not_far_off_its_nodes(axes: int, off: float, steep: float) -> None:
    one = along_one_axis(axes, [-1.0, 0.0], steep)
    made, place = over(axes, one), np.eye(axes)[0]
    found = made.predict(0, place)
    assert found is not None
    assert np.log(found.cost) == pytest.approx(np.clip(steep, min(-steep, 0) - off, max(-steep, 0) + off))
    coordinate = (found.point - one.mean) @ np.linalg.pinv(one.modes.astype(float))[:, 0]
    assert coordinate == pytest.approx(steep, rel=1e-4), "its point is where the tangents lead"
    [nearest] = made.nearest(0, place, 1)
    assert np.log(nearest.cost) == pytest.approx(np.clip(steep, -off, off))


def test_over_many_axes_a_start_s_cost_is_not_led_off_by_nodes_across_a_tear() -> None:
    one = along_one_axis(NEAR_AXES + 1, [-1.0, 0.0], 8.0)
    coordinates = one.coordinates.copy()
    coordinates[0] += 1000.0  # this node is another motion
    found = over(NEAR_AXES + 1, replace(one, coordinates=coordinates)).predict(0, -0.4 * np.eye(NEAR_AXES + 1)[0])
    assert found is not None and np.log(found.cost) == pytest.approx(-MOST_OFF)


def test_nothing_is_blended_across_a_tear() -> None:
    value, gradient = quadratic([1, 0.1, 0.1, 0, 0, 0])
    one = sheet_of(value, gradient)
    other = grid().index((2, 2))
    coordinates = one.coordinates.copy()
    coordinates[other] += 1000.0  # this node is another motion
    made = atlas(replace(one, coordinates=coordinates))
    assert predicted(made, 2.1, 2.1)[1] == pytest.approx(1000.0 + value(2.1, 2.1), rel=1e-4)
    assert predicted(made, 2.6, 2.6)[1] == pytest.approx(value(2.6, 2.6), rel=1e-3), "and it takes no part beside"
    whole = atlas(replace(one, coordinates=coordinates, tear=1e6))
    assert predicted(whole, 2.6, 2.6)[1] > 10


def test_a_tear_is_measured_along_the_tangents() -> None:
    value, gradient = quadratic([1, 50, 0, 0, 0, 0])
    made = atlas(replace(sheet_of(value, gradient), tear=1e-2))
    assert predicted(made, 1.5, 1.5)[1] == pytest.approx(value(1.5, 1.5), rel=1e-4), "50 apart, but one motion"


def test_support_falls_where_nodes_end() -> None:
    value, gradient = quadratic([1, 0, 0, 0, 0, 0])
    left = [place for place in grid() if place[0] <= 1]
    made = atlas(sheet_of(value, gradient, places=left))
    supports = [made.costs(np.array([x, 2.0]) * STEPS)[1][0] for x in (0.5, 1.0, 1.4, 1.6, 2.2, 2.6)]
    assert supports == sorted(supports, reverse=True)
    assert supports[1] >= SUPPORT > supports[3] and supports[4] > 0 == supports[5]


@given(inner)
def test_amid_nodes_costs_are_believed(place: tuple[float, float]) -> None:
    value, gradient = quadratic([1, 0, 0, 0, 0, 0])
    assert atlas(sheet_of(value, gradient)).costs(np.array(place) * STEPS)[1][0] >= SUPPORT


def constant(log: float) -> Values:
    return lambda x, y: log, lambda x, y: (0.0, 0.0)


def test_ranked_has_one_sheet_a_gait_the_believed_and_cheap_first() -> None:
    left = [place for place in grid() if place[0] <= 1]
    dear, cheap = sheet_of(*constant(3.0), gait=0), sheet_of(*constant(2.0), gait=0)
    partly = sheet_of(*constant(1.0), gait=1, places=left)
    made = atlas(dear, cheap, partly)
    assert made.ranked(np.array([0.5, 2.0]) * STEPS) == [2, 1]
    assert made.ranked(np.array([1.9, 2.0]) * STEPS) == [1, 2], "little speaks for the other gait"
    assert made.ranked(np.array([3.5, 2.0]) * STEPS) == [1]
    assert made.by_cost(np.array([1.9, 2.0]) * STEPS) == [1, 0, 2], "all sheets of all gaits"
    assert made.ranked(np.array([9.0, 9.0]) * STEPS) == []
    assert atlas(cheap, cheap).ranked(np.array([1.5, 1.5]) * STEPS) == [0], "of equal ones the first"


@given(inner, coefficients)
def test_where_nodes_agree_a_cost_is_not_doubted(place: tuple[float, float], c: list[float]) -> None:
    made = atlas(sheet_of(*quadratic([*c[:3], 0, 0, 0])))
    costs, _ = made.costs(np.array(place) * STEPS)
    assert made.least_costs(np.array(place) * STEPS) == pytest.approx(costs, rel=1e-5)


@given(st.floats(0, 4), st.floats(0, 4))
def test_across_a_kink_a_cost_may_be_less_by_as_much_as_nodes_disagree(left: float, right: float) -> None:
    made = atlas(
        sheet_of(lambda x, y: 1.0, lambda x, y: (left if x < 1 else -right, 0.0), places=[(0, 0), (1, 0)]),
        sheet_of(*constant(1.0), places=[(0, 0), (1, 0)], gait=1),
    )
    half_way = np.array([0.5, 0.0]) * STEPS
    costs, _ = made.costs(half_way)
    promises = 1 + left / 2, 1 + right / 2
    spread = abs(promises[0] - promises[1]) / 2
    assert np.log(made.least_costs(half_way)) == pytest.approx(np.log(costs) - [DOUBT * spread, 0], abs=1e-6)


@pytest.mark.parametrize(("axes", "most"), [(3, np.inf), (4, np.log(MOST_BELOW))])
def test_over_many_axes_a_cost_is_not_much_less(axes: int, most: float) -> None:
    places, slopes = np.zeros((2, axes)), np.zeros((2, axes))
    places[1, 0], slopes[:, 0] = 1.0, 2.0  # half-way one node promises e, the other 1 / e
    made = Atlas(tuple("abcd"[:axes]), np.ones(axes), 1e-4, (sheet(places, np.ones(2), slopes),))
    half_way = places.mean(axis=0)
    promised = np.log(made.costs(half_way)[0] / made.least_costs(half_way))
    assert promised == pytest.approx([min(DOUBT, most)])


@pytest.mark.parametrize(
    ("away", "support", "promised"),
    [(0.1, SUPPORT, np.e), (0.8, TRIED, np.e), (1.2, HARDLY_TRIED, HARDLY * np.e), (1.45, 0.0, np.inf), (9, 0, np.inf)],
)
def test_with_less_support_less_is_promised(away: float, support: float, promised: float) -> None:
    made, place = atlas(sheet_of(*constant(1.0), places=[(0, 0), (0, 1)])), np.array([away, 0.5]) * STEPS
    assert made.costs(place)[1][0] >= support
    assert made.least_costs(place) == pytest.approx([promised])


def test_nearest_nodes_come_nearest_first_by_their_tangents() -> None:
    value, gradient = quadratic([0, 1, 2, 3, 4, 5])
    made = atlas(sheet_of(value, gradient))
    found = made.nearest(0, np.array([3.9, 1.1]) * STEPS, 3)
    for each, (x, y) in zip(found[:2], ((4, 1), (3, 1)), strict=True):
        slope = gradient(x, y)
        assert np.log(each.cost) == pytest.approx(value(x, y) + slope[0] * (3.9 - x) + slope[1] * (1.1 - y), rel=1e-6)
    one = atlas(sheet_of(value, gradient, places=[(0, 0)]))
    far = one.nearest(0, np.array([9.0, 9.0]) * STEPS, 5)
    assert len(far) == 1 and np.log(far[0].cost) == pytest.approx(value(0, 0), abs=1e-9), "out of reach: as it is"


@pytest.mark.parametrize("axes", [("cycle_duration",), ("speed", "cycle_duration", "slope")])
def test_any_number_of_axes(axes: tuple[str, ...]) -> None:
    steps = np.array([0.2, 0.1, 10.0])[: len(axes)]
    rng = np.random.default_rng(0)
    slope = rng.normal(size=len(axes))
    places = np.array(np.meshgrid(*[np.arange(3.0)] * len(axes))).reshape(len(axes), -1).T
    one = sheet(places * steps, np.exp(places @ slope), np.tile(slope / steps, (len(places), 1)))
    made = Atlas(axes, steps, 1e-4, (one,))
    for place in rng.uniform(0.3, 1.7, (20, len(axes))):
        assert np.log(made.predict(0, place * steps).cost) == pytest.approx(place @ slope)
        costs, support = made.costs(place * steps)
        assert np.log(costs[0]) == pytest.approx(place @ slope) and support[0] > SUPPORT
        assert np.log(made.least_costs(place * steps)) == pytest.approx([place @ slope])


def test_a_part_of_the_gaits_is_renumbered() -> None:
    made = atlas(*(sheet_of(*constant(1.0), gait=gait) for gait in range(3)))
    assert [each.gait for each in made.of([2, 0]).sheets] == [1, 0]
    assert made.of([]).sheets == ()


@pytest.mark.filterwarnings("error")
def test_however_far_a_place_nothing_is_an_accident() -> None:
    made = atlas(sheet_of(*quadratic([1, 2, 3, 4, 5, 6])))
    for far in ((1e300, 0.0), (0.5, -1.7e308), (1e300, 1e300)):
        place = np.array(far)
        assert made.ranked(place) == [] and made.predict(0, place) is None
        assert len(made.nearest(0, place, 2)) == 2 and made.least_costs(place) == [np.inf]
    empty = Atlas.empty(AXES)
    assert empty.ranked(np.array([0.5, 0.5])) == []


def test_the_order_of_the_sheets_nodes_changes_nothing_but_rounding() -> None:
    value, gradient = quadratic([1, 2, 3, 4, 5, 6])
    forth, back = sheet_of(value, gradient), sheet_of(value, gradient, places=grid()[::-1])
    for x, y in ((1.3, 2.2), (0.4, 3.7)):
        assert predicted(atlas(forth), x, y) == pytest.approx(predicted(atlas(back), x, y), rel=1e-5)


def test_a_real_atlas_predicts_its_own_nodes(tiny: TinyMap, grown: Growth) -> None:
    made = tiny.atlas
    for number, one in enumerate(made.sheets):
        assert isinstance(one, Sheet)
        away = []
        for place, cost in zip(one.tasks, one.costs, strict=True):
            assert made.costs(place)[0][number] == pytest.approx(cost)
            found = one.space.decode(made.predict(number, place).point)
            node = one.space.decode(grown.nodes[number][tuple(place.tolist())].point)
            away.append(np.abs(found.free - node.free).max())
        assert np.quantile(away, 0.9) < 0.1


@given(inner, st.floats(0.05, 1.4), st.floats(0, 2 * np.pi))
def test_a_place_without_a_motion_takes_support_and_no_cost(
    place: tuple[float, float], distance: float, angle: float
) -> None:
    assume(min(np.linalg.norm(np.array(node) - place) for node in grid()) > 0.1)
    value, gradient = quadratic([1, 2, 3, 4, 5, 6])
    plain, asked = sheet_of(value, gradient), np.array(place) * STEPS
    without = np.array([place]) + distance * np.array([[np.cos(angle), np.sin(angle)]])
    costs, support = atlas(plain).costs(asked)
    same_costs, less = atlas(replace(plain, infeasible=without * STEPS)).costs(asked)
    assert same_costs.tolist() == costs.tolist()
    assert 0 < less[0] < support[0]
    upon = replace(plain, infeasible=np.array([place]) * STEPS)
    assert atlas(upon).costs(asked)[1][0] < 1e-6


def test_a_gait_comes_last_where_it_has_no_motion() -> None:
    value, gradient = quadratic([0, 0, 0, 0, 0, 0])
    dear = sheet_of(lambda x, y: 1 + value(x, y), gradient, gait=1)
    cheap = replace(sheet_of(value, gradient), infeasible=np.array([[2.4, 2.4]]) * STEPS)
    made = atlas(cheap, dear)
    assert made.ranked(np.array([1.5, 1.5]) * STEPS) == [0, 1]
    assert made.ranked(np.array([2.45, 2.4]) * STEPS) == [1, 0]
    assert made.least_costs(np.array([2.45, 2.4]) * STEPS)[0] == np.inf


def test_of_gaits_that_are_not_believed_the_best_supported_comes_first() -> None:
    value, gradient = quadratic([0, 0, 0, 0, 0, 0])
    dear = replace(sheet_of(lambda x, y: 1 + value(x, y), gradient, gait=1), infeasible=np.array([[2.4, 2.8]]) * STEPS)
    cheap = replace(sheet_of(value, gradient), infeasible=np.array([[2.4, 2.4]]) * STEPS)
    made, place = atlas(cheap, dear), np.array([2.45, 2.5]) * STEPS
    _, support = made.costs(place)
    assert 0 < support[0] < support[1] < SUPPORT
    assert made.ranked(place) == [1, 0]
    again = atlas(cheap, replace(dear, infeasible=cheap.infeasible))
    assert again.ranked(place) == [0, 1], "of equal support the cheaper one"


@given(st.lists(st.tuples(st.floats(-2.0, 7.0), st.floats(-2.0, 7.0)), min_size=1, max_size=5), coefficients)
def test_costs_of_many_places_are_those_of_each(places: list[tuple[float, float]], c: list[float]) -> None:
    value, gradient = quadratic(c)
    left = [place for place in grid() if place[0] <= 1]
    without = replace(sheet_of(value, gradient, places=left), infeasible=np.array([[1.5, 2.0], [2.5, 3.0]]) * STEPS)
    made = atlas(sheet_of(value, gradient), without)
    costs, support = made.costs_of_many(np.array(places) * STEPS)
    assert costs.shape == support.shape == (len(places), 2)
    for place, *found in zip(places, costs, support, strict=True):
        for many, one in zip(found, made.costs(np.array(place) * STEPS), strict=True):
            np.testing.assert_allclose(many, one, rtol=1e-9, atol=1e-12)


def test_an_atlas_that_knows_nothing_has_no_costs_of_many() -> None:
    costs, support = Atlas.empty(AXES).costs_of_many(np.ones((3, 2)))
    assert costs.shape == support.shape == (3, 0)
