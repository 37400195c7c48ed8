from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safetensors.numpy import load, save
from sheets import AXES, LAYOUT, ROWS, atlas, sheet_of, space
from tiny_map import TinyMap

from gaitflow.runtime import ArtifactError
from gaitflow.runtime.atlas import Atlas, Prediction, Sheet
from gaitflow.runtime.atlas_file import (
    BOUNDS,
    EXPONENTS,
    LEVELS,
    ROUNDED_ALONG,
    atlas_bytes,
)
from gaitflow.runtime.atlas_reader import MAX_MODES, MAX_SHEETS, parse_atlas
from gaitflow.runtime.condensed import Condenser
from gaitflow.runtime.fixed_point import WHOLE, rounded, single
from gaitflow.runtime.sheet_image import SheetImage, imaged
from gaitflow.runtime.strict import LARGEST
from gaitflow.solvers.point import GaitSpace

GAITS = 2
PLACES = [np.array(place) for place in ((0.1, 0.5), (0.15, 0.55), (0.3, 0.9), (-5.0, 99.0))]


def flat(gait: int = 0, places: list | None = None) -> Sheet:
    return sheet_of(lambda x, y: 1.0 + x, lambda x, y: (1.0, 0.0), places, gait)


def parse(content: bytes) -> Atlas:
    return parse_atlas(content, AXES, GAITS, LAYOUT, ROWS, "a")


def same(one: Atlas, other: Atlas) -> None:
    assert (one.axes, one.barrier) == (other.axes, other.barrier)
    np.testing.assert_array_equal(one.steps, other.steps)
    for mine, theirs in zip(one.sheets, other.sheets, strict=True):
        assert (mine.gait, mine.pattern, mine.tear) == (theirs.gait, theirs.pattern, theirs.tear)
        for name in ("tasks", "costs", "slopes", "mean", "modes", "coordinates", "tangents", "infeasible"):
            np.testing.assert_array_equal(getattr(mine, name), getattr(theirs, name))
        for name in ("lower", "upper", "lower_rows", "upper_rows"):
            np.testing.assert_array_equal(getattr(mine.space, name), getattr(theirs.space, name))


def test_an_empty_atlas_is_a_file() -> None:
    same(parse(atlas_bytes(Atlas.empty(AXES))), Atlas.empty(AXES))


def test_what_was_written_is_read() -> None:
    made = atlas(flat(0), flat(1, [(0, 0), (2, 1)]))
    content = atlas_bytes(made)
    same(parse(content), made)
    assert atlas_bytes(parse(content)) == content
    with pytest.raises(ValueError, match="read-only"):
        parse(content).sheets[0].mean[0] = 1.0


def test_places_without_a_motion_are_written_where_there_are_any() -> None:
    without = np.array([(0.1, 0.5), (0.2, 0.7)])
    made = atlas(replace(flat(0), infeasible=without), flat(1))
    content = atlas_bytes(made)
    same(parse(content), made)
    assert set(load(content)) - set(load(atlas_bytes(atlas(flat(0), flat(1))))) == {"0.infeasible"}


@pytest.mark.parametrize(
    ("places", "fault"),
    [
        (np.zeros((0, 2)), "0.infeasible is empty"),
        (np.zeros((1, 3)), r"0.infeasible is float64 \(1, 3\); expected float64 \(1, 2\)"),
        (np.array([[25.0, 0.5]]), "sheet 0 has a node or an infeasible place that is no physical task"),
        (np.array([[np.nan, 0.5]]), "0.infeasible holds a value that is not finite"),
        (np.zeros(3), "0.infeasible is float64"),
    ],
)
def test_odd_places_without_a_motion_are_refused(places: np.ndarray, fault: str) -> None:
    with pytest.raises(ArtifactError, match=fault):
        parse(save(load(CONTENT) | {"0.infeasible": places}))


def test_a_real_atlas_round_trips(tiny: TinyMap) -> None:
    problem = tiny.problem
    found = parse_atlas(atlas_bytes(tiny.atlas), tuple(tiny.domain.axes), 2, problem.layout, problem.ng, "a")
    same(found, tiny.atlas)


# Damage. Values that are only different are the digest's business; here nothing but ArtifactError may come out.


def as_older(content: bytes) -> bytes:
    """As older maps have it: bounds and numbers written out, and no images."""
    tensors = {name: values for name, values in load(content).items() if not name.startswith("2.")}
    tensors["sheets"] = np.array([2], dtype=np.int32)
    levels = tensors.pop(LEVELS)
    for name in [name for name in tensors if name.endswith(EXPONENTS)]:
        exponents, whole = tensors.pop(name), name.removesuffix(EXPONENTS)
        tensors[whole] = single(tensors[whole], exponents)
    bounds = {name: levels[which] for name, which in tensors.items() if name.split(".")[-1] in BOUNDS}
    return save(tensors | bounds)


def in_fixed_point(sheet: Sheet) -> Sheet:
    return replace(sheet, **{name: rounded(getattr(sheet, name), along) for name, along in ROUNDED_ALONG.items()})


def condensed(sheet: Sheet) -> Sheet:
    size = Condenser(sheet.space, 1e-4).size
    return replace(sheet, mean=sheet.mean[:size], modes=sheet.modes[:, :size])


def swapped(sheet: Sheet) -> Sheet:
    """A sheet whose numbers are those of another one, in the reverse order."""
    image = SheetImage(
        sheet.pattern, np.arange(len(sheet.mean))[::-1].copy(), np.full(len(sheet.mean), -1, dtype=np.int8)
    )
    return imaged(sheet, image, 1, "10/01", sheet.space, np.ones(len(AXES)))


MADE = [in_fixed_point(condensed(replace(flat(0), pattern="11/01"))), in_fixed_point(flat(1, [(0, 0), (2, 1)]))]
CONTENT = atlas_bytes(atlas(*MADE, swapped(MADE[0])))
OLDER = as_older(CONTENT)
CONTENTS = [CONTENT, OLDER]
contents = st.sampled_from(CONTENTS)


def test_an_older_file_says_the_same() -> None:
    assert LEVELS in load(CONTENT) and "0.modes" + EXPONENTS in load(CONTENT)
    assert len(OLDER) > len(CONTENT)
    same(parse(OLDER), replace(parse(CONTENT), sheets=parse(CONTENT).sheets[:2]))


def test_an_image_is_read_as_it_was_made() -> None:
    made = atlas(*MADE, swapped(MADE[0]))
    same(parse(CONTENT), made)
    assert parse(CONTENT).sheets[2].image is not None
    assert atlas_bytes(parse(CONTENT)) == CONTENT


def refused_or_sound(content: bytes) -> None:
    try:
        made = parse(content)
    except ArtifactError as error:
        assert str(error).startswith("a: ") and len(str(error)) < 500
        return
    with np.errstate(all="ignore"):
        for place in PLACES:
            for number in made.ranked(place):
                finite_start(made, number, made.predict(number, place))
            for number in range(len(made.sheets)):
                for found in made.nearest(number, place, 2):
                    finite_start(made, number, found)
            made.least_costs(place)


def finite_start(made: Atlas, number: int, found: Prediction) -> None:
    own = made.sheets[number].space
    assert all(np.isfinite(each).all() for each in own.join(own.decode(found.point), found.cost))


@given(contents, st.data())
def test_flipped_bits_are_refused_or_harmless(content: bytes, data: st.DataObject) -> None:
    header = 8 + int.from_bytes(content[:8], "little")
    positions = st.one_of(st.integers(0, header - 1), st.integers(0, len(content) - 1))
    flipped = bytearray(content)
    for position, bit in data.draw(st.lists(st.tuples(positions, st.integers(0, 7)), min_size=1, max_size=4)):
        flipped[position] ^= 1 << bit
    refused_or_sound(bytes(flipped))


@given(contents, st.floats(0, 1, exclude_max=True))
def test_truncated_files_are_refused(content: bytes, share: float) -> None:
    with pytest.raises(ArtifactError, match=r"^a: "):
        parse(content[: int(share * len(content))])


@given(st.binary(max_size=200))
def test_garbage_is_refused(content: bytes) -> None:
    with pytest.raises(ArtifactError, match=r"^a: "):
        parse(content)
    with pytest.raises(ArtifactError, match=r"^a: "):
        parse(len(content).to_bytes(8, "little") + content)


@pytest.mark.parametrize(
    ("content", "name"),
    [
        pytest.param(content, name, id=f"{name}-{way}")
        for way, content in (("today", CONTENT), ("older", OLDER))
        for name in sorted(load(content))
    ],
)
@pytest.mark.parametrize("oddity", ["missing", "type", "scalar", "longer", "shorter", "empty", "another axis"])
def test_odd_tensors_are_refused(content: bytes, name: str, oddity: str) -> None:
    tensors = load(content)
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
    with pytest.raises(ArtifactError, match=r"^a: "):
        parse(save(tensors))


@given(
    contents.flatmap(lambda content: st.tuples(st.just(content), st.sampled_from(sorted(load(content))))),
    st.sampled_from([np.nan, np.inf, -np.inf, 0.0, -1.0, 1e300, -1e300, 1e38, 5e-324, 255.0, 2**31 - 1, -(2**31)]),
    st.integers(0, 2**31),
)
def test_odd_values_are_refused_or_harmless(tensor: tuple[bytes, str], value: float, where: int) -> None:
    content, name = tensor
    tensors = load(content)
    numbers = tensors[name].reshape(-1)
    with np.errstate(all="ignore"):
        numbers[where % len(numbers)] = np.array(value).astype(numbers.dtype)
    refused_or_sound(save(tensors))


def changed(content: bytes, **values: object) -> bytes:
    tensors = load(content)
    for name, value in values.items():
        name = name.replace("_of_", ".", 1).removeprefix("n")
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
        ({"n1_of_tasks": 25.0}, "sheet 1 has a node or an infeasible place that is no physical task"),
        ({"n0_of_costs": 0.0}, "a cost that is not positive"),
        ({"n0_of_costs": 1e308}, "0.costs holds a value that is not finite, or beyond 1e+15"),
        ({"n0_of_upper": 1e308}, "0.upper holds a value that is not finite, or beyond 1e+15"),
        ({"n0_of_tear": -1.0}, "a negative tear"),
        ({"n0_of_mean": np.nan}, "0.mean holds a value that is not finite"),
        ({"n0_of_tangents": np.inf}, "0.tangents holds a value that is not finite"),
        ({"barrier": 1.0}, "barrier = 1: must lie between 0 and 1"),
        ({"steps": [0.1, 0.0]}, "steps must be positive"),
        ({"sheets": 1}, "1.coordinates is missing or too much"),
        ({"sheets": 3}, "2.coordinates is missing or too much"),
        ({"sheets": -1}, "sheets = -1"),
        ({"sheets": MAX_SHEETS + 1}, f"sheets = {MAX_SHEETS + 1}"),
    ],
)
def test_a_wrong_value_is_named(values: dict[str, object], fault: str) -> None:
    with pytest.raises(ArtifactError) as caught:
        parse(changed(OLDER, **values))
    assert fault in str(caught.value)


@pytest.mark.parametrize(
    ("values", "fault"),
    [
        ({"n0_of_lower": 255}, "0.lower has level 255; there are"),
        ({"n2_of_image_of": 2}, "sheet 2 is the image of sheet 2, which is not there or an image itself"),
        ({"n2_of_image_of": -1}, "sheet 2 is the image of sheet -1"),
        ({"n2_of_image_of": 1}, "sheet 2 is no image of sheet 1: its numbers do not follow"),
        ({"n2_of_image_places": 0}, "sheet 2 is no image of sheet 0"),
        ({"n2_of_image_signs": 0}, "sheet 2 is no image of sheet 0"),
        ({"levels": 1.0}, "levels are more than 256, or not in ascending order"),
        ({"levels": np.nan}, "levels holds a value that is not finite"),
        ({"n0_of_modes": WHOLE, "n0_of_modes_exponents": 2000}, "0.modes_exponents leads beyond 1e+15"),
        ({"n1_of_tangents": WHOLE, "n1_of_tangents_exponents": 60}, "1.tangents_exponents leads beyond 1e+15"),
    ],
)
def test_a_wrong_value_of_today_s_format_is_named(values: dict[str, object], fault: str) -> None:
    with pytest.raises(ArtifactError) as caught:
        parse(changed(CONTENT, **values))
    assert fault in str(caught.value)


def test_the_largest_numbers_that_a_file_may_hold_give_finite_starts() -> None:
    names = ("costs", "slopes", "mean", "modes", "coordinates", "tangents", "tear")
    for sign in (1, -1):
        most = {f"n{n}_of_{name}": LARGEST * 0.9 for n in (0, 1) for name in names}
        made = parse(changed(OLDER, **most | {f"n{n}_of_slopes": sign * LARGEST for n in (0, 1)}))
        for place in PLACES:
            for number in made.ranked(place):
                finite_start(made, number, made.predict(number, place))
            for number in (0, 1):
                finite_start(made, number, made.nearest(number, place, 2)[-1])


def test_a_header_that_would_take_minutes_is_refused() -> None:
    with pytest.raises(ArtifactError, match=r"^a: a header of 8000001 bytes; it may have at most 8000000"):
        parse((8_000_001).to_bytes(8, "little") + b" " * 100)


def test_a_name_of_two_lines_is_told_in_one() -> None:
    with pytest.raises(ArtifactError, match=r"^a: 'b\\nc' is missing or too much"):
        parse(save(load(CONTENT) | {"b\nc": np.zeros(1)}))


def test_a_type_of_two_lines_is_told_in_one() -> None:
    header = b'{"a":{"dtype":"b\\nc","shape":[0],"data_offsets":[0,0]}}'
    with pytest.raises(ArtifactError, match=r"^a: not a safetensors file .*unknown variant `b\\nc`") as caught:
        parse(len(header).to_bytes(8, "little") + header)
    assert str(caught.value).isprintable()


def test_axes_are_those_of_the_map() -> None:
    with pytest.raises(ArtifactError, match=r"axes are speed, slope; the map's are speed, cycle_duration"):
        parse_atlas(CONTENT, ("speed", "cycle_duration"), GAITS, LAYOUT, ROWS, "a")
    unknown = replace(atlas(), axes=("speed", "height"))
    with pytest.raises(ArtifactError, match=r"'speed,height'; this gaitflow knows speed, "):
        parse(atlas_bytes(unknown))


def test_a_gait_that_leaves_nothing_to_solve_is_refused() -> None:
    nw, no_rows = LAYOUT.nw, np.full(ROWS, np.inf)
    nothing_free = GaitSpace(np.zeros(nw), np.zeros(nw), space().lower_rows, space().upper_rows)
    no_row = GaitSpace(space().lower, space().upper, -no_rows, no_rows)
    no_bound = GaitSpace(np.full(nw, -np.inf), np.full(nw, np.inf), np.zeros(ROWS), np.zeros(ROWS))
    for each in (nothing_free, no_row, no_bound):
        one = replace(
            flat(),
            space=each,
            mean=np.zeros(each.size, dtype=np.float32),
            modes=np.zeros((2, each.size), dtype=np.float32),
        )
        with pytest.raises(ArtifactError, match="sheet 0 leaves no variable, no row or no bound"):
            parse(atlas_bytes(atlas(one)))


def test_more_than_memory_is_for_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    many = replace(flat(), modes=np.zeros((MAX_MODES + 1, flat().space.size), dtype=np.float32))
    with pytest.raises(ArtifactError, match=r"513 modes"):
        parse(atlas_bytes(atlas(many)))
    monkeypatch.setattr("gaitflow.runtime.atlas_reader.MAX_NODES", 26)
    with pytest.raises(ArtifactError, match=r"the atlas has 27 nodes: more than 26"):
        parse(CONTENT)
