"""The Arrow schema of a table of solutions, and the way there and back without loss.

One row a solve. Its task is in one column for each axis that the scenario ranges over. Trajectories are flat fixed-size
lists of float64 in row-major order; a field's metadata tell its unit (`unit`), its shape (`shape`, such as "41,2,2")
and what its axes are (`axes`). A row without a trajectory has nulls there. Multipliers are lists, as their length
follows from the solver's scaled problem rather than from the robot.

Where forces are linear only the last step of a phase needs a force at its end, since within a phase a step ends with
the force that the next one begins with: `end_forces` has a row a phase. Where forces are held there is no such column.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import prod
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from gaitflow.core.layout import Layout
from gaitflow.core.task import AXES
from gaitflow.core.task_space import TaskSpace
from gaitflow.core.trajectory import Trajectory
from gaitflow.search.solution import Solution
from gaitflow.solvers.point import Multipliers

SCALARS: dict[str, tuple[pa.DataType, str]] = {
    "split": (pa.string(), ""),
    "pattern": (pa.string(), ""),
    "gait": (pa.string(), ""),
    "strategy": (pa.string(), ""),
    "start": (pa.string(), ""),
    "seed": (pa.int64(), ""),
    "status": (pa.string(), ""),
    "solver_status": (pa.string(), ""),
    "cost": (pa.float64(), "of the scenario's objective"),
    "refined_cost": (pa.float64(), "of the scenario's objective"),
    "refined_knots": (pa.int64(), "knots per phase"),
    "violation": (pa.float64(), "scaled by the kind of constraint"),
    "iterations": (pa.int64(), ""),
    "solves": (pa.int64(), ""),
    "wall_s": (pa.float64(), "s"),
    "cpu_s": (pa.float64(), "s"),
}  # beside the axes of the task
TRAJECTORY = ("times", "base", "feet", "forces", "end_forces", "foot_velocities", "durations")
MULTIPLIERS = {"bound_multipliers": "bounds", "row_multipliers": "rows"}  # column: field of Multipliers
HEAVY = (*TRAJECTORY, *MULTIPLIERS)  # columns that a published table may leave null

Array = NDArray[np.float64]


def task_columns(names: Iterable[str]) -> list[str]:
    """Which of a table's columns say what the task is: its axes, in their order there, and the split."""
    return [*(name for name in names if name in AXES), "split"]


def scalar_columns(names: Iterable[str]) -> list[str]:
    """Which of a table's columns have one value a row: the task's and SCALARS."""
    return [name for name in names if name in AXES or name in SCALARS]


def row_order(names: Iterable[str]) -> list[str]:
    """The columns by which a table's rows are sorted: split, task (its last axis first), pattern, seed and start."""
    *axes, split = task_columns(names)
    return [split, *reversed(axes), "pattern", "seed", "start"]


def array_shapes(layout: Layout) -> dict[str, tuple[int, ...]]:
    """Shapes of a trajectory's columns: K+1 knots, nb base states, K steps, legs, d coordinates, phases."""
    k, legs, d = layout.steps, layout.legs, layout.dimension
    shapes: dict[str, tuple[int, ...]] = {
        "times": (k + 1,),
        "base": (k + 1, layout.nb),
        "feet": (k + 1, legs, d),
        "forces": (k, legs, d),
        "end_forces": (layout.phases, legs, d),
        "foot_velocities": (k, legs, d),
        "durations": (layout.phases,),
    }
    return shapes if layout.linear_forces else {name: shape for name, shape in shapes.items() if name != "end_forces"}


def solution_schema(scenario: Mapping[str, Any]) -> pa.Schema:
    """Schema of a table of a scenario's solutions; `scenario` is its JSON data (`Scenario.as_data`)."""
    described = {
        "times": ("knot", "s"),
        "base": ("knot,state", "m, rad, m/s, rad/s"),
        "feet": ("knot,leg,coordinate", "m"),
        "forces": ("step,leg,coordinate", "N"),
        "end_forces": ("phase,leg,coordinate", "N"),
        "foot_velocities": ("step,leg,coordinate", "m/s"),
        "durations": ("phase", "s"),
    }
    axes = TaskSpace.of(scenario).columns
    columns = [pa.field(axis, pa.float64(), False, {"unit": AXES[axis].unit}) for axis in axes]
    columns += [pa.field(name, kind, False, {"unit": unit}) for name, (kind, unit) in SCALARS.items()]
    for name, shape in array_shapes(Layout.of(scenario)).items():
        about, unit = described[name]
        metadata = {"unit": unit, "shape": ",".join(map(str, shape)), "axes": about}
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
    if not isinstance(field.type, pa.FixedSizeListType) or prod(shape) != field.type.list_size or shape != expected:
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
