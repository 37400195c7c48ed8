"""The Arrow schema of a table of solutions, and the way there and back without loss.

One row a solve. Trajectories are flat fixed-size lists of float64 in row-major order; a field's metadata tell its
unit (`unit`), its shape (`shape`, such as "41,2,2") and its axes (`axes`). A row without a trajectory has nulls there.
Multipliers are lists, as their length follows from the solver's scaled problem rather than from the robot.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from math import prod
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from gaitflow.config.scenario import Scenario
from gaitflow.core.trajectory import Trajectory
from gaitflow.search.solution import Multipliers, Solution

SCALARS: dict[str, tuple[pa.DataType, str]] = {
    "speed": (pa.float64(), "m/s"),
    "cycle_duration": (pa.float64(), "s"),
    "split": (pa.string(), ""),
    "pattern": (pa.string(), ""),
    "gait": (pa.string(), ""),
    "strategy": (pa.string(), ""),
    "start": (pa.string(), ""),
    "seed": (pa.int64(), ""),
    "status": (pa.string(), ""),
    "solver_status": (pa.string(), ""),
    "cost": (pa.float64(), "of the scenario's objective"),
    "violation": (pa.float64(), "scaled by the kind of constraint"),
    "iterations": (pa.int64(), ""),
    "solves": (pa.int64(), ""),
    "wall_s": (pa.float64(), "s"),
    "cpu_s": (pa.float64(), "s"),
}
TRAJECTORY = tuple(field.name for field in fields(Trajectory))
MULTIPLIERS = {"bound_multipliers": "bounds", "row_multipliers": "rows"}  # column: field of Multipliers
HEAVY = (*TRAJECTORY, *MULTIPLIERS)  # columns that a published table may leave null


@dataclass(frozen=True)
class Sizes:
    """Array sizes of a scenario's trajectories: K steps, nb base states, legs, d coordinates, phases."""

    steps: int
    base_states: int
    legs: int
    dimension: int
    phases: int

    @classmethod
    def of(cls, scenario: Scenario) -> Sizes:
        """Sizes under a scenario's transcription: K = phases * knots_per_phase, nb = 6 in the plane, 12 in space."""
        robot, transcription = scenario.robot, scenario.transcription
        angles = 1 if robot.dimension == 2 else 3
        return cls(
            steps=transcription.phases * transcription.knots_per_phase,
            base_states=2 * (robot.dimension + angles),
            legs=len(robot.legs),
            dimension=robot.dimension,
            phases=transcription.phases,
        )


def solution_schema(sizes: Sizes) -> pa.Schema:
    """Schema of a table of solutions whose trajectories have these sizes."""
    k, legs, d = sizes.steps, sizes.legs, sizes.dimension
    arrays = {
        "times": ((k + 1,), "knot", "s"),
        "base": ((k + 1, sizes.base_states), "knot,state", "m, rad, m/s, rad/s"),
        "feet": ((k + 1, legs, d), "knot,leg,coordinate", "m"),
        "forces": ((k, legs, d), "step,leg,coordinate", "N"),
        "foot_velocities": ((k, legs, d), "step,leg,coordinate", "m/s"),
        "durations": ((sizes.phases,), "phase", "s"),
    }
    columns = [pa.field(name, kind, False, {"unit": unit}) for name, (kind, unit) in SCALARS.items()]
    for name in TRAJECTORY:
        shape, axes, unit = arrays[name]
        metadata = {"unit": unit, "shape": ",".join(map(str, shape)), "axes": axes}
        columns.append(pa.field(name, pa.list_(pa.float64(), prod(shape)), True, metadata))
    columns += [pa.field(name, pa.list_(pa.float64()), True, {"unit": "scaled"}) for name in MULTIPLIERS]
    return pa.schema(columns)


def schema_difference(found: pa.Schema, expected: pa.Schema) -> str | None:
    """What sets a table's schema apart from the expected one, in one phrase; None when they agree."""
    if found.names != expected.names:
        odd = sorted(set(found.names) ^ set(expected.names))
        return f"columns differ: {', '.join(odd) or 'their order'}"
    for have, want in zip(found, expected, strict=True):
        shapes = [(field.metadata or {}).get(b"shape") for field in (have, want)]
        if have.type != want.type or shapes[0] != shapes[1]:
            return f"column {want.name} is {have.type} of shape {shapes[0]!r}, expected {want.type} of {shapes[1]!r}"
    return None


def solutions_to_table(solutions: Sequence[Solution], sizes: Sizes) -> pa.Table:
    """A table with one row a solution. Raises ValueError that names an array of another shape than `sizes` allows."""
    schema = solution_schema(sizes)
    columns: list[pa.Array] = [
        pa.array([getattr(row, name) for row in solutions], kind, from_pandas=False)
        for name, (kind, _) in SCALARS.items()
    ]
    for name in TRAJECTORY:
        shape = _shape(schema.field(name))
        rows = [_flat(row, name, shape) for row in solutions]
        absent = pa.array([row is None for row in rows], pa.bool_())
        blank = np.zeros(prod(shape))
        values = np.concatenate([blank if row is None else row for row in rows]) if rows else np.zeros(0)
        columns.append(pa.FixedSizeListArray.from_arrays(pa.array(values), prod(shape), mask=absent))
    for part in MULTIPLIERS.values():
        lists = [None if row.multipliers is None else getattr(row.multipliers, part) for row in solutions]
        columns.append(pa.array(lists, pa.list_(pa.float64()), from_pandas=False))
    return pa.Table.from_arrays(columns, schema=schema)


def table_to_solutions(table: pa.Table) -> Iterator[Solution]:
    """The solutions of a table that `solutions_to_table` made, exactly as they were, in row order.

    Arrays are read-only views where Arrow allows it. Raises ValueError when a column is missing or lacks its shape.
    """
    missing = [name for name in (*SCALARS, *HEAVY) if name not in table.column_names]
    if missing:
        raise ValueError(f"not a table of solutions: it lacks the column(s) {', '.join(missing)}")
    scalars = {name: table[name].to_pylist() for name in SCALARS}
    arrays = {name: _rows(table[name], _shape(table.schema.field(name))) for name in TRAJECTORY}
    lists = {part: _lists(table[name]) for name, part in MULTIPLIERS.items()}
    for i in range(table.num_rows):
        plan: dict[str, Any] = {name: rows[i] for name, rows in arrays.items()}
        dual: dict[str, Any] = {name: rows[i] for name, rows in lists.items()}
        yield Solution(
            **{name: values[i] for name, values in scalars.items()},
            trajectory=Trajectory(**plan) if all(x is not None for x in plan.values()) else None,
            multipliers=Multipliers(**dual) if all(x is not None for x in dual.values()) else None,
        )


def _shape(field: pa.Field) -> tuple[int, ...]:
    text = (field.metadata or {}).get(b"shape", b"").decode("ascii", "replace")
    shape = tuple(int(part) for part in text.split(",") if part.isdigit())
    if not isinstance(field.type, pa.FixedSizeListType) or not shape or prod(shape) != field.type.list_size:
        raise ValueError(f"not a table of solutions: column {field.name} is {field.type} with the shape {text!r}")
    return shape


def _flat(row: Solution, name: str, shape: tuple[int, ...]) -> NDArray[np.float64] | None:
    if row.trajectory is None:
        return None
    array = np.asarray(getattr(row.trajectory, name), dtype=np.float64)
    if array.shape != shape:
        raise ValueError(
            f"solution of {row.pattern} at speed {row.speed:g}, cycle_duration {row.cycle_duration:g}: {name} has the "
            f"shape {array.shape}, the scenario's transcription gives {shape}"
        )
    return array.ravel()


def _rows(column: pa.ChunkedArray, shape: tuple[int, ...]) -> list[NDArray[np.float64] | None]:
    rows: list[NDArray[np.float64] | None] = []
    for chunk in column.chunks:
        present = np.asarray(chunk.is_valid())
        values = chunk.flatten().to_numpy(zero_copy_only=False).reshape(-1, *shape)  # flatten() leaves nulls out
        position = np.cumsum(present) - 1
        rows += [values[position[i]] if there else None for i, there in enumerate(present)]
    return rows


def _lists(column: pa.ChunkedArray) -> list[NDArray[np.float64] | None]:
    return [x.values.to_numpy(zero_copy_only=False) if x.is_valid else None for x in column]
