"""Solutions as a table and back, without loss."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import prod
from typing import Any

import numpy as np
import pyarrow as pa

from gaitflow.core.layout import Layout
from gaitflow.core.task import AXES
from gaitflow.core.task_space import TaskSpace
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.search.solution import Solution
from gaitflow.solvers.point import Multipliers
from gaitflow.tables.schema import MULTIPLIERS, SCALARS, array_shapes, solution_schema


def solutions_to_table(solutions: Sequence[Solution], scenario: Mapping[str, Any]) -> pa.Table:
    """A table with one row a solution; `scenario` is the scenario's JSON data.

    Raises ValueError that names an array of another shape than the scenario's, or a task that it cannot have.
    """
    schema, layout, space = solution_schema(scenario), Layout.of(scenario), TaskSpace.of(scenario)
    axes = space.columns
    for task in {row.task for row in solutions}:
        if space.task({axis: task[axis] for axis in axes}, task.split) != task:
            raise ValueError(f"the task {task.text(AXES)} is not one of {scenario.get('name', 'the scenario')}")
    columns: list[pa.Array] = [pa.array([row.task[axis] for row in solutions], pa.float64()) for axis in axes]
    columns.append(pa.array([row.task.split for row in solutions], pa.string()))
    columns += [
        pa.array([getattr(row, name) for row in solutions], kind, from_pandas=False)
        for name, (kind, _) in SCALARS.items()
        if name != "split"
    ]
    for name, shape in array_shapes(layout).items():
        rows = [_flat(row, name, shape, layout) for row in solutions]
        absent = pa.array([row is None for row in rows], pa.bool_())
        blank = np.zeros(prod(shape))
        values = np.concatenate([blank if row is None else row for row in rows]) if rows else np.zeros(0)
        columns.append(pa.FixedSizeListArray.from_arrays(pa.array(values), prod(shape), mask=absent))
    for part in MULTIPLIERS.values():
        lists = [None if row.multipliers is None else getattr(row.multipliers, part) for row in solutions]
        columns.append(pa.array(lists, pa.list_(pa.float64()), from_pandas=False))
    return pa.Table.from_arrays(columns, schema=schema)


def table_to_solutions(table: pa.Table, scenario: Mapping[str, Any]) -> Iterator[Solution]:
    """The solutions of a table that `solutions_to_table` made, exactly as they were, in row order.

    Its arrays may have lost their fixed size, as those of `read_table` have.
    Arrays are read-only views where Arrow allows it. Raises ValueError when a column is missing or lacks its shape.
    """
    space, layout = TaskSpace.of(scenario), Layout.of(scenario)
    shapes = array_shapes(layout)
    missing = [name for name in (*space.columns, *SCALARS, *shapes, *MULTIPLIERS) if name not in table.column_names]
    if missing:
        raise ValueError(f"not a table of solutions: it lacks the column(s) {', '.join(missing)}")
    scalars = {name: table[name].to_pylist() for name in SCALARS}
    places = [
        dict(zip(space.columns, row, strict=True))
        for row in zip(*(table[axis].to_pylist() for axis in space.columns), strict=True)
    ]
    arrays = {name: _rows(table[name], _shape(table.schema.field(name), shape)) for name, shape in shapes.items()}
    lists = {part: _lists(table[name]) for name, part in MULTIPLIERS.items()}
    for i in range(table.num_rows):
        plan = {name: rows[i] for name, rows in arrays.items()}
        dual: dict[str, Any] = {name: rows[i] for name, rows in lists.items()}
        yield Solution(
            task=space.task(places[i], scalars["split"][i]),
            **{name: values[i] for name, values in scalars.items() if name != "split"},
            trajectory=_trajectory(plan, layout),
            multipliers=Multipliers(**dual) if all(x is not None for x in dual.values()) else None,
        )


def _trajectory(stored: Mapping[str, Array | None], layout: Layout) -> Trajectory | None:
    arrays = {name: array for name, array in stored.items() if array is not None}
    if len(arrays) < len(stored):
        return None
    ends = arrays["forces"]
    if layout.linear_forces:
        ends = np.roll(ends, -1, axis=0)
        ends[layout.knots_per_phase - 1 :: layout.knots_per_phase] = arrays["end_forces"]
    return Trajectory(**(arrays | {"end_forces": ends}))


def _shape(field: pa.Field, expected: tuple[int, ...]) -> tuple[int, ...]:
    text = (field.metadata or {}).get(b"shape", b"").decode("ascii", "replace")
    shape = tuple(int(part) for part in text.split(",") if part.isdigit())
    is_list = field.type == pa.list_(pa.float64())  # as `read_table` gives them
    if shape != expected or not (is_list or field.type == pa.list_(pa.float64(), prod(shape))):
        raise ValueError(
            f"not a table of solutions: column {field.name} is {field.type} with the shape {text!r}, "
            f"expected the shape {expected}"
        )
    return shape


def _flat(row: Solution, name: str, shape: tuple[int, ...], layout: Layout) -> Array | None:
    if row.trajectory is None:
        return None
    array = np.asarray(getattr(row.trajectory, name), dtype=np.float64)
    if name == "end_forces":
        array = array[layout.knots_per_phase - 1 :: layout.knots_per_phase]
    if array.shape != shape:
        raise ValueError(
            f"solution of {row.pattern} at {row.task.text()}: {name} has the shape {array.shape}, the scenario's "
            f"transcription gives {shape}"
        )
    return array.ravel()


def _rows(column: pa.ChunkedArray, shape: tuple[int, ...]) -> list[Array | None]:
    rows: list[Array | None] = []
    for chunk in column.chunks:
        present = np.asarray(chunk.is_valid())
        values = chunk.flatten().to_numpy(zero_copy_only=False).reshape(-1, *shape)  # flatten() leaves nulls out
        position = np.cumsum(present) - 1
        rows += [values[position[i]] if there else None for i, there in enumerate(present)]
    return rows


def _lists(column: pa.ChunkedArray) -> list[Array | None]:
    return [x.values.to_numpy(zero_copy_only=False) if x.is_valid else None for x in column]
