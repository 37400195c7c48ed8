from __future__ import annotations

import dataclasses
import io
from collections.abc import Callable
from typing import get_args

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitflow.config.scenario import Scenario
from gaitflow.core.trajectory import Trajectory
from gaitflow.dataset.schema import (
    HEAVY,
    SCALARS,
    Sizes,
    schema_difference,
    solution_schema,
    solutions_to_table,
    table_to_solutions,
)
from gaitflow.search.solution import Multipliers, Solution, Status
from gaitflow.store.units import Unit

NUMBER = st.floats(allow_nan=True, allow_infinity=True, width=64)
COUNT = st.integers(0, 2**62)


def arrays(*shape: int) -> st.SearchStrategy[np.ndarray]:
    size = int(np.prod(shape))
    return st.lists(NUMBER, min_size=size, max_size=size).map(lambda xs: np.array(xs, dtype=np.float64).reshape(shape))


def solutions(sizes: Sizes) -> st.SearchStrategy[Solution]:
    k, legs, d = sizes.steps, sizes.legs, sizes.dimension
    trajectory = st.builds(
        Trajectory,
        times=arrays(k + 1),
        base=arrays(k + 1, sizes.base_states),
        feet=arrays(k + 1, legs, d),
        forces=arrays(k, legs, d),
        foot_velocities=arrays(k, legs, d),
        durations=arrays(sizes.phases),
    )
    multipliers = st.builds(
        Multipliers, bounds=st.integers(0, 3).flatmap(arrays), rows=st.integers(0, 3).flatmap(arrays)
    )
    numbers = dict.fromkeys(("speed", "cycle_duration", "cost", "violation", "wall_s", "cpu_s"), NUMBER)
    texts = dict.fromkeys(("pattern", "gait", "strategy", "start", "solver_status"), st.text(max_size=9))
    return st.builds(
        Solution,
        **numbers,
        **texts,
        split=st.sampled_from(["grid", "held_out"]),
        status=st.sampled_from(get_args(Status)),
        seed=COUNT,
        iterations=COUNT,
        solves=COUNT,
        trajectory=st.none() | trajectory,
        multipliers=st.none() | multipliers,
    )


SMALL = Sizes(steps=2, base_states=6, legs=1, dimension=2, phases=2)


def same(a: object, b: object) -> bool:
    """Equality down to the bit, so that -0.0 and NaN count."""
    if dataclasses.is_dataclass(a):
        return type(a) is type(b) and all(
            same(getattr(a, field.name), getattr(b, field.name)) for field in dataclasses.fields(a)
        )
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.shape == b.shape and a.tobytes() == b.tobytes()
    if isinstance(a, float):
        return isinstance(b, float) and np.float64(a).tobytes() == np.float64(b).tobytes()
    return a == b


@settings(max_examples=60)
@given(st.lists(solutions(SMALL), max_size=4))
def test_round_trip_through_parquet_is_exact(rows: list[Solution]) -> None:
    buffer = io.BytesIO()
    pq.write_table(solutions_to_table(rows, SMALL), buffer)
    back = list(table_to_solutions(pq.read_table(buffer)))
    assert len(back) == len(rows)
    assert all(same(a, b) for a, b in zip(rows, back, strict=True))


def test_a_slice_of_a_table_gives_its_own_rows(
    units: tuple[Unit, ...], make_solutions: Callable[[Unit], list[Solution]]
) -> None:
    rows = make_solutions(units[0])
    table = solutions_to_table(rows, Sizes.of(units[0].scenario))
    for start in range(len(rows)):
        back = list(table_to_solutions(pa.concat_tables([table.slice(start, 2), table.slice(0, 1)])))
        assert all(same(a, b) for a, b in zip([*rows[start : start + 2], rows[0]], back, strict=True))


def test_sizes_and_metadata_follow_the_scenario(scenario: Scenario) -> None:
    sizes = Sizes.of(scenario)
    assert sizes == Sizes(steps=8, base_states=6, legs=2, dimension=2, phases=4)
    schema = solution_schema(sizes)
    assert schema.field("base").metadata[b"shape"] == b"9,6"
    assert schema.field("forces").metadata == {b"unit": b"N", b"shape": b"8,2,2", b"axes": b"step,leg,coordinate"}
    assert set(schema.names) == {*SCALARS, *HEAVY}
    assert {field.name for field in dataclasses.fields(Solution)} - set(SCALARS) == {"trajectory", "multipliers"}


def test_an_array_of_another_shape_is_refused_by_name(
    units: tuple[Unit, ...], make_solutions: Callable[[Unit], list[Solution]]
) -> None:
    sizes = Sizes.of(units[0].scenario)
    with pytest.raises(ValueError, match=r"times has the shape \(9,\)"):
        solutions_to_table(make_solutions(units[0]), dataclasses.replace(sizes, steps=9))


def test_tables_of_others_are_refused() -> None:
    with pytest.raises(ValueError, match="lacks the column"):
        list(table_to_solutions(pa.table({"speed": [1.0]})))
    schema = solution_schema(SMALL)
    bare = pa.schema([field.remove_metadata() for field in schema])
    with pytest.raises(ValueError, match="with the shape ''"):
        list(table_to_solutions(solutions_to_table([], SMALL).cast(bare)))
    assert "column times" in (schema_difference(bare, schema) or "")
    assert schema_difference(schema.remove(0), schema) == "columns differ: speed"
    assert schema_difference(schema, schema) is None
