from __future__ import annotations

import dataclasses
import io
from collections.abc import Callable
from typing import Any, get_args

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from one_leg import one_leg

from gaitflow.core.layout import Layout
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Trajectory
from gaitflow.search.solution import Solution, Status
from gaitflow.solvers.point import Multipliers
from gaitflow.store.units import Unit
from gaitflow.tables.schema import solution_schema
from gaitflow.tables.solutions import solutions_to_table, table_to_solutions

NUMBER = st.floats(allow_nan=True, allow_infinity=True, width=64)
COUNT = st.integers(0, 2**62)


def arrays(*shape: int) -> st.SearchStrategy[np.ndarray]:
    size = int(np.prod(shape))
    return st.lists(NUMBER, min_size=size, max_size=size).map(lambda xs: np.array(xs, dtype=np.float64).reshape(shape))


HELD, LINEAR = one_leg(linear=False), one_leg(linear=True)


def motions(scenario: dict[str, Any]) -> st.SearchStrategy[Trajectory]:
    layout = Layout.of(scenario)
    k, legs, d = layout.steps, layout.legs, layout.dimension

    def built(ends: np.ndarray, forces: np.ndarray, **arrays: np.ndarray) -> Trajectory:
        end_forces = forces
        if layout.linear_forces:
            end_forces = np.roll(forces, -1, axis=0)
            end_forces[layout.knots_per_phase - 1 :: layout.knots_per_phase] = ends
        return Trajectory(forces=forces, end_forces=end_forces, **arrays)

    return st.builds(
        built,
        ends=arrays(layout.phases, legs, d),
        times=arrays(k + 1),
        base=arrays(k + 1, layout.nb),
        feet=arrays(k + 1, legs, d),
        forces=arrays(k, legs, d),
        foot_velocities=arrays(k, legs, d),
        durations=arrays(layout.phases),
    )


def solutions(scenario: dict[str, Any]) -> st.SearchStrategy[Solution]:
    multipliers = st.builds(
        Multipliers, bounds=st.integers(0, 3).flatmap(arrays), rows=st.integers(0, 3).flatmap(arrays)
    )
    task = st.builds(
        lambda speed, slope, split: Task.of(
            {"speed": speed, "cycle_duration": 0.5, "slope": slope, "friction": 0.6}, split
        ),
        st.floats(-20.0, 20.0),
        st.floats(-59.0, 59.0),
        st.sampled_from(["grid", "held_out"]),
    )
    numbers = dict.fromkeys(("cost", "refined_cost", "violation", "wall_s", "cpu_s"), NUMBER)
    texts = dict.fromkeys(("pattern", "gait", "strategy", "start", "solver_status"), st.text(max_size=9))
    return st.builds(
        Solution,
        **numbers,
        **texts,
        task=task,
        status=st.sampled_from(get_args(Status)),
        seed=COUNT,
        iterations=COUNT,
        solves=COUNT,
        refined_knots=COUNT,
        trajectory=st.none() | motions(scenario),
        multipliers=st.none() | multipliers,
    )


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


@pytest.mark.parametrize("scenario_data", [HELD, LINEAR], ids=["held", "linear"])
@settings(max_examples=60)
@given(st.data())
def test_round_trip_through_parquet_is_exact(scenario_data: dict[str, Any], data: st.DataObject) -> None:
    rows = data.draw(st.lists(solutions(scenario_data), max_size=4))
    buffer = io.BytesIO()
    pq.write_table(solutions_to_table(rows, scenario_data), buffer)
    back = list(table_to_solutions(pq.read_table(buffer), scenario_data))
    assert len(back) == len(rows)
    assert all(same(a, b) for a, b in zip(rows, back, strict=True))


def test_a_slice_of_a_table_gives_its_own_rows(
    units: tuple[Unit, ...], make_solutions: Callable[[Unit], list[Solution]]
) -> None:
    rows, scenario = make_solutions(units[0]), units[0].scenario.as_data()
    table = solutions_to_table(rows, scenario)
    for start in range(len(rows)):
        back = list(table_to_solutions(pa.concat_tables([table.slice(start, 2), table.slice(0, 1)]), scenario))
        assert all(same(a, b) for a, b in zip([*rows[start : start + 2], rows[0]], back, strict=True))


def test_an_array_of_another_shape_is_refused_by_name(
    units: tuple[Unit, ...], make_solutions: Callable[[Unit], list[Solution]]
) -> None:
    scenario = units[0].scenario.as_data()
    scenario["transcription"]["knots_per_phase"] = 3
    with pytest.raises(ValueError, match=r"times has the shape \(9,\)"):
        solutions_to_table(make_solutions(units[0]), scenario)


def test_a_task_that_the_scenario_cannot_have_is_refused(
    units: tuple[Unit, ...], make_solutions: Callable[[Unit], list[Solution]]
) -> None:
    rows, scenario = make_solutions(units[0]), units[0].scenario.as_data()
    uphill = dataclasses.replace(rows[0], task=rows[0].task.replaced(slope=10.0))
    with pytest.raises(ValueError, match="slope 10 deg"):
        solutions_to_table([uphill], scenario)


def test_tables_of_others_are_refused() -> None:
    with pytest.raises(ValueError, match="lacks the column"):
        list(table_to_solutions(pa.table({"speed": [1.0]}), HELD))
    schema = solution_schema(HELD)
    bare = pa.schema([field.remove_metadata() for field in schema])
    with pytest.raises(ValueError, match="with the shape ''"):
        list(table_to_solutions(solutions_to_table([], HELD).cast(bare), HELD))
    with pytest.raises(ValueError, match=r"column times is .* expected the shape \(7,\)"):
        list(table_to_solutions(solutions_to_table([], HELD), one_leg(linear=False, knots=3)))
