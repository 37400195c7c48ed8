from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safetensors.numpy import load, save

from gaitflow.atlas.grow import Grown
from gaitflow.publishing import Parts, runtime_layout
from gaitflow.runtime import ArtifactError
from gaitflow.runtime.atlas import MAX_AXIS, MAX_MODES, MAX_SHEETS, Atlas, Sheet, atlas_bytes, parse_atlas
from gaitflow.runtime.layout import Layout
from gaitflow.solvers.point import GaitSpace

LAYOUT = Layout(phases=2, knots_per_phase=1, legs=("F", "H"), dimension=2, base=6, rows=3)
SPEEDS, DURATIONS = (0.1, 0.2, 0.4), (0.5, 0.6, 0.9)
EVERYWHERE = tuple((i, j) for i in range(3) for j in range(3))
GAITS = 2
TASKS = [(0.1, 0.5), (0.15, 0.55), (0.3, 0.9), (-5.0, 99.0)]


def space() -> GaitSpace:
    """All variables free, most of them bounded on one side; an equality, an inequality and a free row."""
    n = LAYOUT.variables
    lower = np.where(np.arange(n) % 3, -1.0, -np.inf)
    upper = np.where(np.arange(n) % 2, 1.0, np.inf)
    return GaitSpace(lower, upper, np.array([0.0, -1.0, -np.inf]), np.array([0.0, 1.0, np.inf]))


def sheet(
    gait: int = 0, places: tuple = EVERYWHERE, costs: float | tuple = 1.0, seed: int = 0, modes: int = 2
) -> Sheet:
    """Random modes; a node's coordinates are its place, so that neighbours are 1 apart."""
    rng, bounds = np.random.default_rng(seed), space()
    coordinates = np.zeros((len(places), modes), dtype=np.float32)
    coordinates[:, :2] = np.array(places, dtype=np.float32).reshape(-1, 2)[:, :modes]
    return Sheet(
        gait=gait,
        pattern="01/10",
        space=bounds,
        places=np.array(places, dtype=np.int32).reshape(-1, 2),
        costs=np.broadcast_to(np.array(costs, dtype=np.float64), len(places)).copy(),
        mean=rng.normal(size=bounds.size).astype(np.float32),
        modes=rng.normal(size=(modes, bounds.size)).astype(np.float32),
        coordinates=coordinates,
        tear=10.0,
    )


def atlas(*sheets: Sheet) -> Atlas:
    return Atlas(SPEEDS, DURATIONS, 1e-4, sheets)


def parse(content: bytes) -> Atlas:
    return parse_atlas(content, GAITS, LAYOUT, "a")


def same(one: Atlas, other: Atlas) -> None:
    assert (one.speeds, one.cycle_durations, one.barrier) == (other.speeds, other.cycle_durations, other.barrier)
    for mine, theirs in zip(one.sheets, other.sheets, strict=True):
        assert (mine.gait, mine.pattern, mine.tear) == (theirs.gait, theirs.pattern, theirs.tear)
        for name in ("places", "costs", "mean", "modes", "coordinates"):
            np.testing.assert_array_equal(getattr(mine, name), getattr(theirs, name))
        for name in ("lower", "upper", "lower_rows", "upper_rows"):
            np.testing.assert_array_equal(getattr(mine.space, name), getattr(theirs.space, name))


def test_at_a_node_the_prediction_is_the_node() -> None:
    one = sheet(costs=tuple(range(1, 10)))
    made = atlas(one)
    for node, (i, j) in enumerate(EVERYWHERE):
        found = made.predict(0, SPEEDS[i], DURATIONS[j])
        assert found.cost == pytest.approx(one.costs[node])
        np.testing.assert_allclose(found.point, one.mean + one.coordinates[node] @ one.modes, rtol=1e-5, atol=1e-5)
        costs, share = made.costs(SPEEDS[i], DURATIONS[j])
        assert (costs[0], share[0]) == pytest.approx((one.costs[node], 1.0))


def test_between_nodes_the_blend_is_bilinear() -> None:
    one = sheet(costs=tuple(np.exp(i + 2 * j) for i, j in EVERYWHERE))
    found = atlas(one).predict(0, 0.25, 0.825)  # a quarter of the way from 0.2 to 0.4, three from 0.6 to 0.9
    np.testing.assert_allclose(found.point, one.mean + np.array([1.25, 1.75]) @ one.modes, rtol=1e-5, atol=1e-5)
    assert found.cost == pytest.approx(np.exp(1.25 + 2 * 1.75)), "costs blend as logarithms"


def test_beyond_the_axes_the_nearest_node_answers() -> None:
    made = atlas(sheet(costs=tuple(range(1, 10))))
    np.testing.assert_array_equal(made.predict(0, -3.0, 9.0).point, made.predict(0, 0.1, 0.9).point)
    assert made.costs(-3.0, 9.0)[0] == pytest.approx([3.0])


def test_nothing_is_blended_across_a_tear() -> None:
    one = sheet()
    far = one.coordinates.copy()
    far[4] += 1000.0  # the node in the middle is another motion
    made = atlas(replace(one, coordinates=far))
    for speed, duration, alone in ((0.19, 0.59, True), (0.12, 0.52, False)):
        found = made.predict(0, speed, duration).point
        expected = one.mean + far[4] @ one.modes
        assert np.allclose(found, expected, atol=1e-2) is alone
        if not alone:
            assert np.abs(found - one.mean).max() < 50, "the motion in the middle has a weight of 4 %"


@pytest.mark.parametrize("tear", [0.5, 2.0])
def test_a_tear_is_what_lies_further_apart_than_said(tear: float) -> None:
    one = replace(sheet(), tear=tear)
    blended = atlas(one).predict(0, 0.14, 0.5).point
    nearest = one.mean + one.coordinates[0] @ one.modes
    assert np.allclose(blended, nearest, atol=1e-4) is (tear < 1)


def test_what_a_cost_rests_on_is_said() -> None:
    made = atlas(sheet(places=((0, 0), (0, 1)), costs=(2.0, 4.0)))
    for speed, expected in ((0.1, 1.0), (0.12, 0.8), (0.18, 0.2), (0.2, 0.0), (0.3, 0.0)):
        costs, share = made.costs(speed, 0.5)
        assert share == pytest.approx([expected], abs=1e-9)
        assert (np.isnan(costs[0]) and made.predict(0, speed, 0.5) is None) or costs[0] == pytest.approx(2.0)


def test_ranked_has_one_sheet_a_gait_the_certain_and_cheap_first() -> None:
    left = tuple(place for place in EVERYWHERE if place[0] == 0)
    dear, cheap, partly = sheet(0, costs=3.0), sheet(0, costs=2.0, seed=1), sheet(1, left, costs=1.0)
    made = atlas(dear, cheap, partly)
    assert made.ranked(0.1, 0.5) == [2, 1]
    assert made.ranked(0.19, 0.5)[0] == 1, "little speaks for the other gait"
    assert {made.sheets[number].gait for number in made.ranked(0.19, 0.5)} == {0, 1}
    assert made.ranked(0.4, 0.9) == [1]
    assert atlas(cheap, cheap).ranked(0.1, 0.5) == [0], "of equal ones the first"


STEPS = (0.1, 0.2, 0.3, 0.4, 0.5)
INNER = st.floats(0.2, 0.4)


@given(INNER, INNER, st.lists(st.tuples(*[st.floats(-20, 20)] * 3), min_size=1, max_size=4))
def test_a_cost_that_rises_ever_faster_lies_between_promise_and_blend(
    speed: float, duration: float, planes: list[tuple[float, float, float]]
) -> None:
    def cost(v: float, t: float) -> float:
        return float(np.exp(max(a * v + b * t + 0.1 * c for a, b, c in planes)))

    places = tuple((i, j) for i in range(5) for j in range(5))
    costs = tuple(cost(STEPS[i], STEPS[j]) for i, j in places)
    made = Atlas(STEPS, STEPS, 1e-4, (sheet(places=places, costs=costs),))
    true = cost(speed, duration)
    assert made.least_cost(0, speed, duration) <= true * (1 + 1e-9)
    assert made.costs(speed, duration)[0][0] >= true * (1 - 1e-9)
    if len(planes) == 1:
        assert made.least_cost(0, speed, duration) == pytest.approx(true), "then both are exact"


def test_before_a_cliff_the_promise_is_what_the_slope_was() -> None:
    places = tuple((i, j) for i in range(5) for j in range(5))
    by_speed = (2.0, 2.0, 2.0, 100.0, 1e6)
    made = Atlas(STEPS, STEPS, 1e-4, (sheet(places=places, costs=tuple(by_speed[i] for i, _ in places)),))
    assert made.costs(0.35, 0.35)[0][0] == pytest.approx(np.sqrt(2.0 * 100.0))
    assert made.least_cost(0, 0.35, 0.35) == pytest.approx(2.0)


def test_without_nodes_nothing_is_promised() -> None:
    assert atlas(sheet()).least_cost(0, 0.15, 0.55) == pytest.approx(1.0)
    partly = atlas(sheet(places=((0, 0), (0, 1), (1, 0))))
    assert partly.least_cost(0, 0.15, 0.55) == np.inf, "no node has neighbours on the far sides of the cell"
    few = atlas(sheet(places=((1, 1), (2, 1), (1, 2))))
    assert few.least_cost(0, 0.15, 0.55) == np.inf, "too few are around"


def test_nearest_nodes_come_nearest_first() -> None:
    one = sheet(costs=tuple(range(1, 10)))
    found = atlas(one).nearest(0, 0.39, 0.61, 3)
    assert found[0].cost == pytest.approx(one.costs[EVERYWHERE.index((2, 1))])
    np.testing.assert_allclose(found[0].point, one.mean + np.array([2.0, 1.0]) @ one.modes, rtol=1e-5, atol=1e-5)
    assert len({node.cost for node in found}) == 3
    assert len(atlas(sheet(places=((0, 0),))).nearest(0, 9.0, 9.0, 5)) == 1


def test_a_part_of_the_gaits_is_renumbered() -> None:
    made = Atlas(SPEEDS, DURATIONS, 1e-4, (sheet(0), sheet(1), sheet(2)))
    kept = made.of([2, 0])
    assert [each.gait for each in kept.sheets] == [1, 0]
    assert [each.gait for each in made.of([]).sheets] == []


def test_an_empty_atlas_knows_nothing_and_is_a_file() -> None:
    empty = Atlas.empty()
    assert empty.ranked(0.5, 0.5) == []
    same(parse(atlas_bytes(empty)), empty)


def test_what_was_written_is_read() -> None:
    made = atlas(sheet(0), sheet(1, ((0, 0), (2, 1)), costs=(1.0, 7.0), seed=5, modes=1))
    content = atlas_bytes(made)
    same(parse(content), made)
    assert atlas_bytes(parse(content)) == content
    with pytest.raises(ValueError, match="read-only"):
        parse(content).sheets[0].mean[0] = 1.0


def test_a_real_atlas_round_trips_and_holds_its_nodes(parts: Parts, grown: Grown) -> None:
    found = parse_atlas(atlas_bytes(parts.atlas), 2, runtime_layout(parts.problem), "a")
    same(found, parts.atlas)
    away = []
    for number, each in enumerate(found.sheets):
        for place, cost in zip(each.places.tolist(), each.costs, strict=True):
            task = found.speeds[place[0]], found.cycle_durations[place[1]]
            assert found.costs(*task)[0][number] == pytest.approx(cost)
            point = each.space.decode(found.predict(number, *task).point)
            away.append(np.abs(point.free - grown.nodes[number][tuple(place)].point.free).max())
    assert np.quantile(away, 0.95) < 0.5  # few modes, and strays replaced


# Damage. Values that are only different are the digest's business; here nothing but ArtifactError may come out.

CONTENT = atlas_bytes(atlas(sheet(0), sheet(1, ((0, 0), (2, 1)), costs=(1.0, 7.0), seed=5, modes=1)))
HEADER = 8 + int.from_bytes(CONTENT[:8], "little")
TENSORS = sorted(load(CONTENT))
positions = st.one_of(st.integers(0, HEADER - 1), st.integers(0, len(CONTENT) - 1))


def refused_or_sound(content: bytes) -> None:
    try:
        made = parse(content)
    except ArtifactError as error:
        assert str(error).startswith("a: ") and len(str(error)) < 500
        return
    with np.errstate(all="ignore"):
        for task in TASKS:
            for number in made.ranked(*task):
                found = made.predict(number, *task)
                made.sheets[number].space.decode(found.point)
            for number in range(len(made.sheets)):
                made.nearest(number, *task, 2)


@given(st.lists(st.tuples(positions, st.integers(0, 7)), min_size=1, max_size=4))
def test_flipped_bits_are_refused_or_harmless(flips: list[tuple[int, int]]) -> None:
    content = bytearray(CONTENT)
    for position, bit in flips:
        content[position] ^= 1 << bit
    refused_or_sound(bytes(content))


@given(st.integers(0, len(CONTENT) - 1))
def test_truncated_files_are_refused(length: int) -> None:
    with pytest.raises(ArtifactError, match=r"^a: "):
        parse(CONTENT[:length])


@given(st.binary(max_size=200))
def test_garbage_is_refused(content: bytes) -> None:
    with pytest.raises(ArtifactError, match=r"^a: "):
        parse(content)
    with pytest.raises(ArtifactError, match=r"^a: "):
        parse(len(content).to_bytes(8, "little") + content)


@pytest.mark.parametrize("name", TENSORS)
@pytest.mark.parametrize("oddity", ["missing", "type", "scalar", "longer", "shorter", "empty", "another axis"])
def test_odd_tensors_are_refused(name: str, oddity: str) -> None:
    tensors = load(CONTENT)
    tensor = tensors.pop(name)
    odd = {
        "type": lambda: tensor.astype(np.float16),
        "scalar": lambda: tensor.ravel()[0:1].reshape(()),
        "longer": lambda: np.concatenate([tensor, tensor]),
        "shorter": lambda: tensor[:-1],
        "empty": lambda: tensor.ravel()[:0],
        "another axis": lambda: tensor[None],
    }
    if oddity != "missing":
        tensors[name] = np.array(odd[oddity](), order="C")
    if name in ("speeds", "cycle_durations") and oddity == "shorter":
        return refused_or_sound(save(tensors))  # nodes off the shorter axis, or none of them
    with pytest.raises(ArtifactError, match=r"^a: "):
        parse(save(tensors))


@given(
    st.sampled_from(TENSORS),
    st.sampled_from([np.nan, np.inf, -np.inf, 0.0, -1.0, 1e300, -1e300, 1e38, 5e-324, 255.0, 2**31 - 1, -(2**31)]),
    st.integers(0, 2**31),
)
def test_odd_values_are_refused_or_harmless(name: str, value: float, where: int) -> None:
    tensors = load(CONTENT)
    flat = tensors[name].reshape(-1)
    with np.errstate(all="ignore"):
        flat[where % len(flat)] = np.array(value).astype(flat.dtype)
    refused_or_sound(save(tensors))


def changed(**values: object) -> bytes:
    tensors = load(CONTENT)
    for name, value in values.items():
        name = name.replace("_of_", ".").removeprefix("n")
        tensors[name] = np.broadcast_to(np.array(value, dtype=tensors[name].dtype), tensors[name].shape).copy()
    return save(tensors)


@pytest.mark.parametrize(
    ("values", "fault"),
    [
        ({"n0_of_gait": 2}, "sheet 0 is of gait 2; the map has 2"),
        ({"n0_of_gait": -1}, "sheet 0 is of gait -1"),
        ({"n1_of_pattern": 2}, "sheet 1 has a pattern of more than 0 and 1"),
        ({"n0_of_lower": 2.0}, "a bound below that lies above the one above"),
        ({"n0_of_lower": np.inf, "n0_of_upper": np.inf}, "infinite"),
        ({"n0_of_lower_rows": -np.inf, "n0_of_upper_rows": -np.inf}, "infinite"),
        ({"n1_of_places": 0}, "two nodes at a task"),
        ({"n1_of_places": [[0, 0], [0, 3]]}, "off the 3 by 3 tasks"),
        ({"n0_of_costs": 0.0}, "a cost that is not positive"),
        ({"n0_of_tear": -1.0}, "a negative tear"),
        ({"n0_of_mean": np.nan}, "0.mean holds a value that is not finite"),
        ({"barrier": 1.0}, "barrier = 1: must lie between 0 and 1"),
        ({"speeds": 0.1}, "speeds must rise"),
        ({"sheets": 1}, "1.coordinates is missing or too much"),
        ({"sheets": 3}, "2.coordinates is missing or too much"),
        ({"sheets": -1}, "sheets = -1"),
        ({"sheets": MAX_SHEETS + 1}, f"sheets = {MAX_SHEETS + 1}"),
    ],
)
def test_a_wrong_value_is_named(values: dict[str, object], fault: str) -> None:
    with pytest.raises(ArtifactError) as caught:
        parse(changed(**values))
    assert fault in str(caught.value)


def test_a_gait_that_leaves_nothing_to_solve_is_refused() -> None:
    nw, no_rows = LAYOUT.variables, np.full(3, np.inf)
    nothing_free = GaitSpace(np.zeros(nw), np.zeros(nw), space().lower_rows, space().upper_rows)
    no_row = GaitSpace(space().lower, space().upper, -no_rows, no_rows)
    no_bound = GaitSpace(np.full(nw, -np.inf), np.full(nw, np.inf), np.zeros(3), np.zeros(3))
    for each in (nothing_free, no_row, no_bound):
        one = replace(
            sheet(),
            space=each,
            mean=np.zeros(each.size, dtype=np.float32),
            modes=np.zeros((2, each.size), dtype=np.float32),
        )
        with pytest.raises(ArtifactError, match="sheet 0 leaves no variable, no row or no bound"):
            parse(atlas_bytes(atlas(one)))


def test_tables_too_large_for_memory_are_refused_before_they_are_made() -> None:
    long = tuple(float(n) for n in range(MAX_AXIS))
    few = sheet(places=((0, 0),))
    with pytest.raises(ArtifactError, match=r"40 sheets over 2000 by 2000 tasks"):
        parse(atlas_bytes(Atlas(long, long, 1e-4, (few,) * 40)))
    with pytest.raises(ArtifactError, match=r"speeds has 2001 values; expected 2 to 2000"):
        parse(atlas_bytes(Atlas((*long, 2000.0), DURATIONS, 1e-4, ())))
    many = replace(few, modes=np.zeros((MAX_MODES + 1, few.space.size), dtype=np.float32))
    with pytest.raises(ArtifactError, match=r"513 modes"):
        parse(atlas_bytes(atlas(many)))
