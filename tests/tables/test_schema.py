from __future__ import annotations

import dataclasses

import pyarrow as pa
from one_leg import one_leg

from gaitflow.config.scenario import Scenario
from gaitflow.search.solution import Solution
from gaitflow.tables.schema import (
    MULTIPLIERS,
    SCALARS,
    TRAJECTORY,
    scalar_columns,
    schema_difference,
    solution_schema,
    task_columns,
)

HELD = one_leg(linear=False)


def test_columns_shapes_and_units_follow_the_scenario(scenario: Scenario) -> None:
    schema = solution_schema(scenario.as_data())
    assert schema.field("base").metadata[b"shape"] == b"9,6"
    assert schema.field("base").metadata[b"states"] == b"x,z,pitch,v_x,v_z,pitch_rate"
    places = {b"axes": b"step,leg,coordinate", b"legs": b"F,H", b"coordinates": b"x,z"}
    assert schema.field("forces").metadata == {b"unit": b"N", b"shape": b"8,2,2"} | places
    assert schema.field("end_forces").metadata[b"shape"] == b"4,2,2"
    assert schema.names == ["speed", "cycle_duration", *SCALARS, *TRAJECTORY, *MULTIPLIERS]
    assert {field.name for field in dataclasses.fields(Solution)} - set(SCALARS) == {
        "task", "trajectory", "multipliers",
    }  # fmt: skip


def test_an_axis_with_a_range_has_a_column_and_held_forces_have_no_end() -> None:
    schema = solution_schema(HELD)
    assert task_columns(schema.names) == ["speed", "cycle_duration", "slope", "split"]
    assert scalar_columns(schema.names) == ["speed", "cycle_duration", "slope", *SCALARS]
    assert schema.field("slope").metadata == {b"unit": b"deg"}
    assert "end_forces" not in schema.names


def test_a_difference_is_told_by_the_column() -> None:
    schema = solution_schema(HELD)
    bare = pa.schema([field.remove_metadata() for field in schema])
    assert "column times" in (schema_difference(bare, schema) or "")
    assert schema_difference(schema.remove(0), schema) == "columns differ: speed"
    assert schema_difference(schema, schema) is None
