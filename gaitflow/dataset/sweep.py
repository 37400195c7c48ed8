"""The labels of many robots as one sealed table, a row a robot and task."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa

from gaitflow.config.file import ConfigError
from gaitflow.config.scenario import Scenario
from gaitflow.config.sweep import Factor, Sample, Sweep
from gaitflow.config.tasks import tasks_of
from gaitflow.core.task import AXES
from gaitflow.dataset.collect import NotComplete
from gaitflow.dataset.labels import gait_costs, label_tasks, mark_failed
from gaitflow.files import new_file
from gaitflow.store.parts import DamagedPart, UnitStore
from gaitflow.store.units import plan_units
from gaitflow.tables.columns import described
from gaitflow.tables.provenance import KEY, made_by
from gaitflow.tables.schema import scalar_columns, solution_schema
from gaitflow.tables.seal import check_seal, write_sealed
from gaitflow.tables.untrusted import opened, read_table

FORMAT, KIND = 1, "sweep"
SAMPLE = "sample"
MAX_ROWS, MAX_BYTES = 100_000_000, 16 << 30
UNITS = {
    "mass": "kg",
    "inertia": "kg m^2",
    "legs": "m",
    "box": "m",
    "max_force": "N",
    "max_foot_speed": "m/s",
    "max_tilt": "rad",
}  # of a robot's parameters, by what their names begin with


@dataclass(frozen=True)
class SweepTable:
    """The labels of a sweep: `frame` has a row a robot and task, `scenario` is the one that was swept.

    Columns of the frame: `sample`, one for each sampled parameter, then those of labels.
    """

    scenario: Scenario
    sweep: Sweep
    frame: pd.DataFrame

    @property
    def labels(self) -> dict[int, pd.DataFrame]:
        """The labels of each robot, by its number."""
        return {int(number): rows for number, rows in self.frame.groupby(SAMPLE)}  # type: ignore[arg-type]

    @property
    def parameters(self) -> pd.DataFrame:
        """What was drawn, a row a robot by its number, a column a parameter."""
        columns = [SAMPLE, *self.sweep.ranges]
        return self.frame[columns].drop_duplicates(SAMPLE).set_index(SAMPLE).sort_index()


def sweep_labels(store: UnitStore, samples: Sequence[Sample]) -> pd.DataFrame:
    """The labels of every sample, its number and values before them.

    Raises NotComplete where units are not solved or damaged; a damaged one goes to quarantine.
    """
    return pd.concat([_labels(store, sample) for sample in samples], ignore_index=True)


def write_sweep(path: Path, scenario: Scenario, sweep: Sweep, frame: pd.DataFrame) -> None:
    """Write the labels of a sweep as a sealed Parquet file, each column with its unit. Raises WriteError."""
    table = described(pa.Table.from_pandas(frame, preserve_index=False)).replace_schema_metadata()
    fields = [field.with_metadata(_meaning(field.name, sweep) or field.metadata) for field in table.schema]
    record = {
        "format": FORMAT,
        "kind": KIND,
        "scenario": scenario.as_data(),
        "sweep": sweep.as_data(),
        "made_by": made_by(),
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    with new_file(path, replace=True) as file:
        write_sealed(file, pa.schema(fields), [table.cast(pa.schema(fields))], record)


def read_sweep(path: Path) -> SweepTable:
    """Read what `write_sweep` wrote. Raises ValueError that names the file when it is damaged or something else."""
    check_seal(path)
    with opened(path, MAX_ROWS) as file:
        table, metadata = read_table(file, path, MAX_BYTES), file.metadata.metadata or {}
    try:
        record: dict[str, Any] = json.loads(metadata[KEY])
        if (record["kind"], record["format"]) != (KIND, FORMAT):
            raise ValueError(f"its record is {record['kind']!r} of format {record['format']!r}")
        scenario = Scenario.from_data(record["scenario"], str(path))
        sweep = Sweep.from_data(record["sweep"], str(path))
    except (KeyError, TypeError, ConfigError, ValueError) as error:
        raise ValueError(f"{path}: is no table of a sweep ({error})") from None
    return SweepTable(scenario, sweep, table.to_pandas())


def _labels(store: UnitStore, sample: Sample) -> pd.DataFrame:
    scenario = sample.scenario
    columns = scalar_columns(solution_schema(scenario.as_data()).names)
    units = plan_units(scenario)
    missing = sum(not store.has(unit) for unit in units)
    if missing:
        raise NotComplete(f"sample {sample.number}: {missing} of {len(units)} units are not solved yet; run the sweep")
    try:
        solutions = pd.concat([store.read(unit, columns).to_pandas() for unit in units], ignore_index=True)
    except DamagedPart as error:
        store.validate_all(units)
        raise NotComplete(f"sample {sample.number}: {error}; run the sweep again") from None
    costs = gait_costs(solutions, scenario.robot.leg_names)
    knots = scenario.transcription.knots_per_phase
    labels = label_tasks(costs, tasks_of(scenario), scenario.learning.tie_tolerance, knots)
    labels = mark_failed(labels, solutions)
    numbers = pd.DataFrame({SAMPLE: sample.number, **sample.values}, index=labels.index)
    return pd.concat([numbers, labels], axis=1)


def _meaning(column: str, sweep: Sweep) -> dict[str, str]:
    if column == SAMPLE:
        return {"meaning": "number of the robot, from 0"}
    if column not in sweep.ranges:
        return {}
    if isinstance(sweep.ranges[column], Factor):
        return {"meaning": f"what the scenario's {column} is multiplied by"}
    unit = AXES[column].unit if column in AXES else UNITS.get(column.split(".")[0], "")
    return {"meaning": f"the sampled {column}"} | ({} if unit in ("", "1") else {"unit": unit})
