"""The stances of a motion as a Parquet file, for whoever works with tables."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from gaitflow.files import new_file
from gaitflow.motion import Motion

COORDINATES = {2: ("x", "z"), 3: ("x", "y", "z")}


def write_contact_schedule(path: Path, motion: Motion, cycles: int = 1, *, replace: bool = False) -> None:
    """Write a row a stance that reaches into the first `cycles` cycles: leg, start and end [s], foothold x, (y,) z [m].

    Rows are by leg and then by time; a leg that always stands has one from -inf to inf. The metadata entries `legs`
    and `cycle_duration` say what the legs are and how long a cycle is [s]. Raises FileExistsError unless `replace`,
    WriteError, and ValueError as `Motion.phases`.
    """
    rows = [(leg, *stance) for leg in motion.leg_names for stance in motion.phases(leg, cycles)]
    columns = {
        "leg": pa.array([row[0] for row in rows], pa.string()),
        "start": pa.array([row[1] for row in rows], pa.float64()),
        "end": pa.array([row[2] for row in rows], pa.float64()),
    }
    for number, name in enumerate(COORDINATES[motion.dimension]):
        columns[name] = pa.array([float(row[3][number]) for row in rows], pa.float64())
    metadata = {"legs": ",".join(motion.leg_names), "cycle_duration": repr(motion.period)}
    with new_file(path, replace=replace) as file:
        pq.write_table(pa.table(columns).replace_schema_metadata(metadata), file)
