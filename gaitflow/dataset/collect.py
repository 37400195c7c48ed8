"""Merging the parts of a run into one dataset file whose rows do not depend on who solved what when."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Task
from gaitflow.dataset.mirror import START, MirrorImage, has_images, images_of
from gaitflow.dataset.read import FILE_NAME, Solutions
from gaitflow.files import new_file
from gaitflow.store.parts import DamagedPart, UnitStore
from gaitflow.store.units import Unit, plan_units
from gaitflow.tables.provenance import dataset_record
from gaitflow.tables.schema import row_order, scalar_columns, solution_schema
from gaitflow.tables.seal import write_sealed
from gaitflow.tables.solutions import solutions_to_table, table_to_solutions

ROWS_PER_GROUP = 2000  # rows held in memory at a time
OPEN_PARTS = 8
TABLES_AT_ONCE = 1000
MAKERS = ("made_by", "solver_options")  # what a dataset's record keeps of those of its parts


class NotComplete(ValueError):
    """Units are missing or damaged, so that there is no dataset yet; the message says how many, and what to do."""


def collect(
    store: UnitStore,
    scenario: Scenario,
    chosen: Sequence[Task] | None = None,
    held_out: Collection[Task] = (),
    target: Path | None = None,
    askings: int = 0,
    rounds: Sequence[Mapping[str, Any]] = (),
) -> Path:
    """Merge every unit of `scenario` into one file, `<store>/solutions.parquet` or `target`, and return its path.

    `chosen` are the tasks of an adaptive sampling, `held_out` those of them that nothing was learnt from. Of the others
    the mirror images are rows, too, where the map has them. `askings` is how often certificates were asked so far,
    `rounds` those of a sampling that was stopped in the middle of one.

    Rows are sorted by split, task (speed fastest), pattern, seed and start. Every part is checked; a bad one goes to
    quarantine.
    Raises NotComplete, WriteError.
    """
    units = plan_units(scenario, None if chosen is None else sorted(chosen))
    stored = store.solved()
    missing = sum(unit.digest not in stored for unit in units)
    if missing:
        raise NotComplete(f"{scenario.name}: {missing} of {len(units)} units are not solved yet; solve them first")
    damaged = store.validate_all(units)
    if damaged:
        raise NotComplete(
            f"{scenario.name}: {len(damaged)} damaged part(s) went to {store.folder / 'quarantine'}; solve again. "
            f"The first: {next(iter(damaged.values()))}"
        )
    try:
        schema = solution_schema(scenario.as_data())
        columns = scalar_columns(schema.names)
        table, records, record_of = _scalars(store, units, columns)
        images = _Images(store, units, held_out, scenario)
        rows = _with_splits(table.to_pandas(), units, held_out)
        rows = pd.concat([rows, *images.scalars(columns)]).sort_values(
            row_order(schema.names), kind="stable", ignore_index=True
        )
        target = store.folder / FILE_NAME if target is None else target
        read = functools.lru_cache(maxsize=OPEN_PARTS)(
            lambda index: store.read(units[index]) if index < len(units) else images.read(index)
        )
        with new_file(target, replace=True) as file:
            record = dataset_record(scenario, [unit.digest for unit in units], records, record_of, askings, rounds)
            write_sealed(file, schema, _tables(rows, read, schema), record)
    except DamagedPart as error:
        raise NotComplete(f"{scenario.name}: a part changed while it was collected: {error}") from None
    return target


def tasks_as_chosen(solutions: Solutions) -> list[Task]:
    """The tasks of an adaptive sampling as they were when they were chosen, in the order of the dataset's units."""
    return sorted(replace(task, split="sampled") for task in searched_rows(solutions).tasks())


def searched_rows(solutions: Solutions) -> Solutions:
    """The rows of a dataset that were searched: without those of mirror images."""
    return Solutions(solutions.table.filter(pc.not_equal(solutions.table["start"], START)), solutions.record)


class _Images:
    """Mirror images of the units that were searched for a map: numbered after the units, row for row as these are."""

    def __init__(self, store: UnitStore, units: Sequence[Unit], held_out: Collection[Task], scenario: Scenario) -> None:
        self._store, self._units, self._scenario = store, units, scenario
        self._image = MirrorImage(scenario)
        self._known = [
            len(units) + index
            for index, unit in enumerate(units)
            if has_images(scenario) and unit.tasks[0] not in held_out and images_of(unit.tasks)
        ]

    def scalars(self, columns: Sequence[str]) -> list[pd.DataFrame]:
        """The scalar columns of each image, with `unit` and `row` as `_scalars` has them."""
        tables = ((index, self.read(index).select(columns).to_pandas()) for index in self._known)
        return [frame.assign(unit=index, row=np.arange(len(frame))) for index, frame in tables]

    def read(self, index: int) -> pa.Table:
        """The table of an image."""
        data = self._scenario.as_data()
        solutions = table_to_solutions(self._store.read(self._units[index - len(self._units)]), data)
        return solutions_to_table([self._image.of(one) for one in solutions], data)


def _with_splits(rows: pd.DataFrame, units: Sequence[Unit], held_out: Collection[Task]) -> pd.DataFrame:
    """The rows with the split that their tasks have in the end: only that shows for what a task was searched."""
    if not held_out:
        return rows
    apart = np.array([unit.tasks[0] in held_out for unit in units])[rows["unit"].to_numpy()]
    return rows.assign(split=rows["split"].where(~apart, "held_out"))


def _scalars(
    store: UnitStore, units: Sequence[Unit], columns: Sequence[str]
) -> tuple[pa.Table, list[dict[str, Any]], list[int]]:
    """Scalar columns of all rows, with where each row is: `unit` (index) and `row` in its part; what made the parts.

    Of the parts' records only those that differ in who made them how, since one a part would not fit into memory; and
    for each unit the place of its record among them.
    """
    tables, makers, maker_of = [], list[dict[str, Any]](), list[int]()
    places = dict[str, int]()
    for index, unit in enumerate(units):
        table, record = store.read_with_record(unit, columns=columns)
        made = {key: record[key] for key in MAKERS}
        text = json.dumps(made, sort_keys=True)
        if text not in places:
            places[text] = len(makers)
            makers.append(made)
        maker_of.append(places[text])
        unit_of, row_of = pa.array(np.full(len(table), index)), pa.array(np.arange(len(table)))
        table = table.replace_schema_metadata().append_column("unit", unit_of).append_column("row", row_of)
        tables.append(table)
        if len(tables) == TABLES_AT_ONCE:  # a table has a price beside that of its rows
            tables = [pa.concat_tables(tables).combine_chunks()]
    return pa.concat_tables(tables), makers, maker_of


def _tables(rows: pd.DataFrame, read: Callable[[int], pa.Table], schema: pa.Schema) -> Iterator[pa.Table]:
    for start in range(0, len(rows), ROWS_PER_GROUP):
        block = rows.iloc[start : start + ROWS_PER_GROUP]
        # One piece per part, then into the block's order.
        pieces, places = [], []
        for index, members in block.groupby("unit", sort=True):
            part = read(int(index))  # type: ignore[arg-type]
            piece = part.select(schema.names).cast(schema).take(pa.array(members["row"]))
            split = pa.array(members["split"], pa.string())
            pieces.append(piece.set_column(schema.get_field_index("split"), schema.field("split"), split))
            places.append(members.index.to_numpy() - start)
        order = np.argsort(np.concatenate(places))
        yield pa.concat_tables(pieces).take(pa.array(order)).combine_chunks()
