"""The Arrow schema of a table of solutions.

One row a solve. Its task is in one column for each axis that the scenario ranges over. Trajectories are flat fixed-size
lists of float64 in row-major order; a field's metadata tell its unit (`unit`), its shape (`shape`, such as "41,2,2"),
what its axes are (`axes`) and what the places along them are called (`states`, `legs`, `coordinates`). A row without a
trajectory has nulls there. Multipliers are lists, as their length follows from the solver's scaled problem rather than
from the robot.

Where forces are linear only the last step of a phase needs a force at its end, since within a phase a step ends with
the force that the next one begins with: `end_forces` has a row a phase. Where forces are held there is no such column.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import prod
from typing import Any

import pyarrow as pa

from gaitflow.core.layout import Layout
from gaitflow.core.task import AXES
from gaitflow.core.task_space import TaskSpace

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
BASE_STATES = {
    2: ("x", "z", "pitch", "v_x", "v_z", "pitch_rate"),
    3: ("x", "y", "z", "yaw", "pitch", "roll", "v_x", "v_y", "v_z", "w_x", "w_y", "w_z"),
}  # by dimension: position, angles, velocity, angular velocity (in space about the base's own axes)
COORDINATES = {2: ("x", "z"), 3: ("x", "y", "z")}
TRAJECTORY = ("times", "base", "feet", "forces", "end_forces", "foot_velocities", "durations")
MULTIPLIERS = {"bound_multipliers": "bounds", "row_multipliers": "rows"}  # column: field of Multipliers
HEAVY = (*TRAJECTORY, *MULTIPLIERS)  # columns that a published table may leave null


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
        metadata = {"unit": unit, "shape": ",".join(map(str, shape)), "axes": about} | _named(about, scenario)
        columns.append(pa.field(name, pa.list_(pa.float64(), prod(shape)), True, metadata))
    columns += [pa.field(name, pa.list_(pa.float64()), True, {"unit": "scaled"}) for name in MULTIPLIERS]
    return pa.schema(columns)


def _named(axes: str, scenario: Mapping[str, Any]) -> dict[str, str]:
    """What the places along an array's axes are called: base states, legs, coordinates."""
    robot = scenario["robot"]
    known = {
        "state": ("states", BASE_STATES[robot["dimension"]]),
        "leg": ("legs", [leg["name"] for leg in robot["legs"]]),
        "coordinate": ("coordinates", COORDINATES[robot["dimension"]]),
    }
    return {known[axis][0]: ",".join(known[axis][1]) for axis in axes.split(",") if axis in known}


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
