"""Tables of earlier formats, and labels with earlier names of gaits, in today's form."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
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


def modern_labels(labels: pd.DataFrame) -> pd.DataFrame:
    """A frame of labels or gait costs with the gaits called as today; columns without names stay as they are."""
    names = {column: labels[column].map(modern_name, na_action="ignore") for column in NAMED if column in labels}
    if "ties" in labels:
        names["ties"] = labels["ties"].map(lambda ties: [modern_name(name) for name in ties])
    return labels.assign(**names)
