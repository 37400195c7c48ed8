"""Tables of earlier formats, and labels with earlier names of gaits, in today's form."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pyarrow as pa

from gaitflow.core.legacy import modern_name
from gaitflow.tables.schema import solution_schema

ADDED = {"refined_cost": np.nan, "refined_knots": 0}  # columns of today, and what they say of an older solution

NAMED = ("gait", "runner_up", "label")


def modern_table(table: pa.Table, scenario: Mapping[str, Any]) -> pa.Table:
    """A table of solutions with all columns of today; one that has them comes back as it is.

    `scenario` is its scenario's JSON data in today's form. Older tables know no cost on a finer mesh. Their forces were
    held over a step, so no column is missing for those. What else a table lacks is left to the reader to refuse.
    """
    if not set(ADDED).isdisjoint(table.column_names):
        return table
    schema = solution_schema(scenario)
    for name, value in ADDED.items():
        table = table.append_column(name, pa.array(np.full(len(table), value), schema.field(name).type))
    known = [name for name in schema.names if name in table.column_names]
    return table.select(known)


def modern_names(table: pa.Table) -> pa.Table:
    """A table of labels or gait costs with the gaits called as today; columns without names stay as they are."""
    for number, field in enumerate(table.schema):
        values = table[field.name].to_pylist() if field.name in (*NAMED, "ties") else []
        if field.name in NAMED:
            called: list[Any] = [None if name is None else modern_name(name) for name in values]
        elif field.name == "ties":
            called = [None if names is None else [modern_name(name) for name in names] for names in values]
        else:
            continue
        table = table.set_column(number, field, pa.array(called, field.type))
    return table
