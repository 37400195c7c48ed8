"""The public reader of a dataset of solutions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, overload

import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from gaitflow.config.file import require_mapping
from gaitflow.core.legacy import modern_scenario
from gaitflow.core.task import Split, Task
from gaitflow.core.task_space import TaskSpace
from gaitflow.core.trajectory import Array
from gaitflow.dataset.legacy import modern_table
from gaitflow.dataset.sound import schema_fault, table_fault
from gaitflow.runtime.remote import local_folder
from gaitflow.search.solution import Solution
from gaitflow.tables.provenance import read_record
from gaitflow.tables.schema import scalar_columns, task_columns
from gaitflow.tables.seal import check_seal
from gaitflow.tables.solutions import table_to_solutions
from gaitflow.tables.untrusted import file_in, opened, read_table

FILE_NAME = "solutions.parquet"
MAX_ROWS = 100_000_000
MAX_BYTES = 16 << 30  # of all columns when unpacked
ROWS_AT_ONCE = 256


@dataclass(frozen=True)
class StoredSolution(Solution):
    """A `Solution` whose task and arrays are at hand directly; an array is None in a row without a trajectory.

    SI units, terrain frame, ground at z = 0. K steps, nb = 6 (plane) or 12 (space), d = 2 or 3.
    """

    @property
    def speed(self) -> float:
        """v [m/s]; any other axis is in `task`, as in `task["slope"]`."""
        return self.task.speed

    @property
    def cycle_duration(self) -> float:
        """T [s]."""
        return self.task.cycle_duration

    @property
    def split(self) -> Split:
        """What the task is for: the training grid or held out."""
        return self.task.split

    @property
    def times(self) -> Array | None:
        """[K+1] s, from 0 to the cycle duration."""
        return None if self.trajectory is None else self.trajectory.times

    @property
    def base(self) -> Array | None:
        """[K+1, nb]: position d [m], angles [rad], velocity d [m/s], angular velocity [rad/s]."""
        return None if self.trajectory is None else self.trajectory.base

    @property
    def feet(self) -> Array | None:
        """[K+1, legs, d] foot positions [m]."""
        return None if self.trajectory is None else self.trajectory.feet

    @property
    def forces(self) -> Array | None:
        """[K, legs, d] contact forces [N] at the start of each step."""
        return None if self.trajectory is None else self.trajectory.forces

    @property
    def end_forces(self) -> Array | None:
        """[K, legs, d] contact forces [N] at the end of each step, to which they run linearly; equal when held."""
        return None if self.trajectory is None else self.trajectory.end_forces

    @property
    def foot_velocities(self) -> Array | None:
        """[K, legs, d] foot velocities [m/s], constant over each step."""
        return None if self.trajectory is None else self.trajectory.foot_velocities

    @property
    def durations(self) -> Array | None:
        """[phases] s; they add up to the cycle duration."""
        return None if self.trajectory is None else self.trajectory.durations


class Solutions(Sequence[StoredSolution]):
    """Solutions in the dataset's row order: by split, task (speed fastest), pattern.

    `table` is the Arrow table, whose arrays have lost their fixed size, so that rows without a motion take no memory.
    `record` is where it comes from (scenario, code, versions; see tables/provenance.py).
    """

    def __init__(self, table: pa.Table, record: dict[str, Any]) -> None:
        self.table = table
        self.record = record

    def __len__(self) -> int:
        return int(self.table.num_rows)

    @overload
    def __getitem__(self, index: int) -> StoredSolution: ...
    @overload
    def __getitem__(self, index: slice) -> Solutions: ...
    def __getitem__(self, index: int | slice) -> StoredSolution | Solutions:
        if isinstance(index, slice):
            return Solutions(self.table.take(list(range(len(self))[index])), self.record)
        row = range(len(self))[index]
        return next(self._stored(row, 1))

    def __iter__(self) -> Iterator[StoredSolution]:
        for start in range(0, len(self), ROWS_AT_ONCE):
            yield from self._stored(start, ROWS_AT_ONCE)

    def frame(self) -> pd.DataFrame:
        """The scalar columns as pandas: task, pattern, gait, status, cost, violation, effort; one row a solution."""
        return self.table.select(scalar_columns(self.table.column_names)).to_pandas()

    def solved(self, patterns: Iterable[str]) -> Solutions:
        """Those that were solved with one of these patterns, chosen in the table: no other row becomes a solution."""
        status, pattern = self.table["status"], self.table["pattern"]
        wanted = pc.and_(pc.equal(status, "solved"), pc.is_in(pattern, pa.array(patterns, pa.string())))
        return Solutions(self.table.filter(wanted), self.record)

    def tasks(self) -> list[Task]:
        """Every task that has a row, in their order."""
        names = task_columns(self.table.column_names)
        space = TaskSpace.of(self.record["scenario"])
        rows = self.frame()[names].drop_duplicates().to_dict("records")
        return [space.task({axis: row[axis] for axis in names[:-1]}, row["split"]) for row in rows]

    def _stored(self, start: int, count: int) -> Iterator[StoredSolution]:
        names = [field.name for field in fields(Solution)]
        for solution in table_to_solutions(self.table.slice(start, count), self.record["scenario"]):
            yield StoredSolution(**{name: getattr(solution, name) for name in names})


def load_solutions(path: str | Path) -> Solutions:
    """Read the solutions of a dataset: a Parquet file, or the folder (of one version) that holds `solutions.parquet`.

    The folder may be at an address, such as s3://bucket/datasets/NAME: see `gaitflow.runtime.remote`.

    Gives, a solution: task (`speed` m/s, `cycle_duration` s, any axis as in `task["slope"]`, `split`), `pattern`,
    `gait`, `status`, `cost`, `violation`, and when a trajectory is kept `times` [K+1], `base` [K+1, nb], `feet`
    [K+1, legs, d], `forces` and `end_forces` [K, legs, d], `durations` [phases]. `.frame()` gives the scalars as
    pandas. Datasets of all versions are read, and come in today's form.
    Raises FileNotFoundError, and ValueError that names the file when it is damaged or not one of ours.
    """
    file_path = file_in(local_folder(path), FILE_NAME)
    check_seal(file_path)
    with opened(file_path, MAX_ROWS) as file:
        record = read_record(file.metadata.metadata, str(file_path))
        if record["kind"] != "dataset":
            raise ValueError(f"{file_path}: is one {record['kind']} of a run, not a dataset")
        try:
            record["scenario"] = modern_scenario(require_mapping(record.get("scenario"), "scenario"))
            fault = schema_fault(file.schema_arrow, record["scenario"])
        except ValueError as error:
            raise ValueError(f"{file_path}: its record holds no scenario ({error})") from None
        if fault is None:
            table = modern_table(read_table(file, file_path, MAX_BYTES), record["scenario"])
            fault = table_fault(table, record["scenario"])
        if fault is not None:
            raise ValueError(f"{file_path}: these are no solutions of its scenario: {fault}")
    return Solutions(table, record)
