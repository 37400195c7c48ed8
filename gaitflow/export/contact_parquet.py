"""The stances of a motion as a Parquet file, for whoever works with tables."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from gaitflow.files import new_file
from gaitflow.motion import Journey, Motion
from gaitflow.motion.contact_schedule import Span, horizon

COORDINATES = {2: ("x", "z"), 3: ("x", "y", "z")}


def write_contact_schedule(
    path: Path, motion: Motion | Journey, cycles: int = 1, span: Span | None = None, *, replace: bool = False
) -> None:
    """Write a row a stance that reaches into the first `cycles` cycles, or into a span (start, stop) [s].

    Columns are leg, start and end [s], foothold x, (y,) z [m]. Rows are by leg and then by time; a leg that always
    stands has one from -inf to inf. The metadata entry `legs` says what the legs are, and `cycle_duration` how long a
    cycle is, or `span` from when to when it was asked for [s]. Raises FileExistsError unless `replace`, WriteError, and
    ValueError as `Motion.phases` and for a journey without a span.
    """
    start, stop = horizon(motion, cycles, span)
    rows = [(leg, *stance) for leg in motion.leg_names for stance in motion.phases(leg, span=(start, stop))]
    columns = {
        "leg": pa.array([row[0] for row in rows], pa.string()),
        "start": pa.array([row[1] for row in rows], pa.float64()),
        "end": pa.array([row[2] for row in rows], pa.float64()),
    }
    for number, name in enumerate(COORDINATES[motion.dimension]):
        columns[name] = pa.array([float(row[3][number]) for row in rows], pa.float64())
    metadata = {"legs": ",".join(motion.leg_names)}
    if isinstance(motion, Motion) and span is None:
        metadata["cycle_duration"] = repr(motion.period)
    else:
        metadata["span"] = f"{start!r},{stop!r}"
    with new_file(path, replace=replace) as file:
        pq.write_table(pa.table(columns).replace_schema_metadata(metadata), file)
