"""Whether a table of solutions that anybody may have written is one: schema, tasks, patterns and motions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern
from gaitflow.core.layout import Layout
from gaitflow.core.task import SPLITS
from gaitflow.core.task_space import TaskSpace
from gaitflow.dataset.legacy import modern_table
from gaitflow.tables.schema import HEAVY, MULTIPLIERS, array_shapes, schema_difference, solution_schema

NAMELESS = {"", "none"}  # patterns of units that failed, and of restarts that ended without one
LARGEST = 1e15  # of a number in a motion: far above what motions hold, and products of several are still finite


def schema_fault(schema: pa.Schema, scenario: Mapping[str, Any]) -> str | None:
    """What sets a file's schema apart from that of the scenario's solutions, in today's form or an older one.

    `scenario` is checked first: raises ConfigError, a ValueError, where it is none.
    """
    Scenario.from_data(scenario, "the scenario in its record")
    return schema_difference(modern_table(schema.empty_table(), scenario).schema, solution_schema(scenario))


def table_fault(table: pa.Table, scenario: Mapping[str, Any]) -> str | None:
    """What is wrong with the values of a table that has the scenario's schema, in one phrase; None where nothing is."""
    expected, space, layout = solution_schema(scenario), TaskSpace.of(scenario), Layout.of(scenario)
    for field in expected:
        if not field.nullable and table[field.name].null_count:
            return f"the column {field.name} has rows without a value"
    tasks = table.select([*space.columns, "split"]).group_by([*space.columns, "split"]).aggregate([]).to_pylist()
    for row in tasks:
        split = row.pop("split")
        if split not in SPLITS:
            return f"split = {split[:80]!r}: must be one of {', '.join(SPLITS)}"
        try:
            space.task(row, split)
        except ValueError as error:
            return f"a task is none of the scenario's: {error}"
    texts = table.select(["status", "pattern", "gait"])  # without the motions, of which a filter makes a copy
    is_solved = pc.equal(texts["status"], "solved")
    solved, unsolved = texts.filter(is_solved), texts.filter(pc.invert(is_solved))
    for name in ("pattern", "gait"):
        nameless = set(pc.unique(unsolved[name]).to_pylist()) & NAMELESS
        for text in set(pc.unique(solved[name]).to_pylist()) | set(pc.unique(texts[name]).to_pylist()) - nameless:
            if fault := _pattern_fault(name, text, layout):
                return fault
    return _motion_fault(table, layout)


def _pattern_fault(name: str, text: str, layout: Layout) -> str | None:
    try:
        pattern = Pattern.from_text(text)
    except ValueError as error:
        return f"{name}: {error}"
    fits = pattern.phases == layout.phases if name == "pattern" else pattern.phases <= layout.phases
    if pattern.legs == layout.legs and fits:
        return None
    return f"{name} = {text[:80]!r}: the scenario has {layout.legs} legs and {layout.phases} phases"


def _motion_fault(table: pa.Table, layout: Layout) -> str | None:
    """A row has a whole motion or none, of finite numbers."""
    motion = list(array_shapes(layout))
    stored = [np.asarray(table[name].is_valid()) for name in motion]
    if any((each != stored[0]).any() for each in stored):
        return "a row has a part of a motion"
    for name in HEAVY:
        if name not in table.column_names:
            continue
        for chunk in table[name].chunks:
            values = chunk.flatten()
            numbers = values.to_numpy(zero_copy_only=False)
            if values.null_count or not (np.abs(numbers) <= LARGEST).all():
                return f"the column {name} holds a number that is not finite, or beyond {LARGEST:g}"
    for name in MULTIPLIERS:
        if len(pc.unique(pc.list_value_length(table[name].drop_null()))) > 1:
            return f"rows of the column {name} differ in length"
    return None
