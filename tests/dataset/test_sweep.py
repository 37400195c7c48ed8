"""The table of a sweep: labels of many robots, read back as they were written."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
import pyarrow.parquet as pq
import pytest
from small_units import filled

from gaitflow.config.sweep import Sample, Sweep, sampled
from gaitflow.dataset.collect import NotComplete
from gaitflow.dataset.sweep import SweepTable, read_sweep, sweep_labels, write_sweep
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import plan_units

RANGES = {"mass": [10.0, 20.0], "inertia": {"factor": [0.5, 2.0]}, "payload": [0.0, 2.0]}
SWEEP = Sweep.from_data({"name": "two", "samples": 2, "ranges": RANGES}, "test")


@pytest.fixture(scope="module")
def samples(scenario) -> tuple[Sample, ...]:
    return sampled(scenario, SWEEP)


def solved(store: UnitStore, samples: tuple[Sample, ...], make_solutions) -> UnitStore:
    return filled(store, tuple(unit for one in samples for unit in plan_units(one.scenario)), make_solutions)


def written(path: Path, scenario, frame: pd.DataFrame) -> SweepTable:
    write_sweep(path, scenario, SWEEP, frame)
    return read_sweep(path)


def test_every_robot_has_a_row_a_task_with_what_was_drawn(tmp_path, store, scenario, samples, make_solutions) -> None:
    frame = sweep_labels(solved(store, samples, make_solutions), samples)
    table = written(tmp_path / "sweep.parquet", scenario, frame)
    assert (table.scenario, table.sweep) == (scenario, SWEEP)
    assert len(table.frame) == 2 * 6 and sorted(table.labels) == [0, 1], "the grid's tasks, none held out"
    for one in samples:
        assert dict(table.parameters.loc[one.number]) == one.values
        rows = table.labels[one.number]
        assert (rows["status"] == "solved").all() and (rows["gait"] == "gallop").all()
        assert list(rows["cost"]) == [100.0 * speed for speed in rows["speed"]]
        assert (rows["payload"] == one.values["payload"]).all()


def test_columns_tell_their_units_and_the_file_where_it_comes_from(
    tmp_path, store, scenario, samples, make_solutions
) -> None:
    path = tmp_path / "sweep.parquet"
    written(path, scenario, sweep_labels(solved(store, samples, make_solutions), samples))
    schema = pq.read_schema(path)
    units = {name: (schema.field(name).metadata or {}).get(b"unit") for name in ("mass", "inertia", "payload", "speed")}
    assert units == {"mass": b"kg", "inertia": None, "payload": b"kg", "speed": b"m/s"}
    assert schema.field("inertia").metadata[b"meaning"] == b"what the scenario's inertia is multiplied by"
    record = json.loads(pq.read_metadata(path).metadata[b"gaitflow"])
    assert record["scenario"] == scenario.as_data() and record["sweep"] == SWEEP.as_data()
    assert record["made_by"]["packages"]["casadi"]


def test_a_sweep_with_a_unit_missing_has_no_table(store, samples, make_solutions) -> None:
    units = plan_units(samples[0].scenario)
    filled(store, units, make_solutions)
    with pytest.raises(NotComplete, match=f"sample 1: {len(units)} of {len(units)} units are not solved yet"):
        sweep_labels(store, samples)


def test_a_damaged_unit_goes_to_quarantine_and_is_named(store, samples, make_solutions) -> None:
    solved(store, samples, make_solutions)
    unit = plan_units(samples[1].scenario)[0]
    content = bytearray(store.path(unit.digest).read_bytes())
    content[len(content) // 2] ^= 1
    store.path(unit.digest).write_bytes(content)
    with pytest.raises(NotComplete, match=f"sample 1: .*{unit.digest}.*run the sweep again"):
        sweep_labels(store, samples)
    assert not store.has(unit) and list((store.folder / "quarantine").glob("*.parquet"))


def test_a_damaged_or_foreign_table_is_refused(tmp_path, store, scenario, samples, make_solutions) -> None:
    path = tmp_path / "sweep.parquet"
    written(path, scenario, sweep_labels(solved(store, samples, make_solutions), samples))
    content = bytearray(path.read_bytes())
    content[len(content) // 3] ^= 1
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"sweep\.parquet: damaged"):
        read_sweep(path)
    with pytest.raises(ValueError, match="is no table of a sweep"):
        read_sweep(store.path(plan_units(samples[0].scenario)[0].digest))
