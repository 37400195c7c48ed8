from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest

from gaitflow.config.scenario import Scenario
from gaitflow.core.check import FEASIBLE, worst
from gaitflow.dataset import Solutions, load_solutions
from gaitflow.dataset.collect import collect
from gaitflow.search.solution import Solution
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit
from gaitflow.tables.seal import write_sealed


@pytest.fixture
def dataset(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], make_solutions: Callable[[Unit], list[Solution]]
) -> Path:
    for unit in units:
        store.write(unit, make_solutions(unit), {})
    return collect(store, scenario)


def test_arrays_have_the_documented_shapes(dataset: Path) -> None:
    solutions = load_solutions(dataset)
    (k, legs, d, nb, phases) = (8, 2, 2, 6, 4)
    solved = [row for row in solutions if row.status == "solved"]
    assert solved
    for row in solved:
        assert row.times.shape == (k + 1,) and row.base.shape == (k + 1, nb) and row.feet.shape == (k + 1, legs, d)
        assert row.forces.shape == row.end_forces.shape == row.foot_velocities.shape == (k, legs, d)
        assert row.durations.shape == (phases,)
        assert row.base.dtype == np.float64 and isinstance(row.cost, float) and "/" in row.pattern
    (infeasible, *_) = [row for row in solutions if row.status == "infeasible"]
    assert infeasible.times is None and infeasible.base is None and np.isnan(infeasible.violation)
    assert infeasible.end_forces is None and np.isnan(infeasible.refined_cost)


def test_a_dataset_of_an_older_version_comes_in_today_s_form(checkout: Path) -> None:
    solutions = load_solutions(checkout / "tests/data/datasets/half-cheetah-slope20-vibration/1.0.0")
    scenario = Scenario.from_data(solutions.record["scenario"], "record")
    assert scenario.tasks.axes["slope"] == 20.0 and scenario.transcription.forces == "held"
    frame = solutions.frame()
    assert frame["refined_cost"].isna().all() and (frame["refined_knots"] == 0).all()
    row = next(row for row in solutions if row.trajectory is not None)
    assert row.task["slope"] == 20.0 and row.task["friction"] == 0.8 and row.speed == row.task["speed"] > 0
    assert (row.forces == row.end_forces).all()
    assert worst(solutions.record["scenario"], row.trajectory, row.task, row.pattern) <= FEASIBLE
    assert row.multipliers is not None and row.multipliers.bounds.ndim == 1


def test_a_part_of_a_run_is_no_dataset(store: UnitStore, dataset: Path, units: tuple[Unit, ...]) -> None:
    with pytest.raises(ValueError, match="one unit of a run"):
        load_solutions(store.path(units[0].digest))


def test_it_is_a_sequence(dataset: Path) -> None:
    solutions = load_solutions(str(dataset.parent))
    rows = list(solutions)
    assert len(solutions) == len(rows) == len(solutions.frame())
    assert solutions[-1].pattern == rows[-1].pattern and solutions[4].speed == rows[4].speed
    part = solutions[2:8:2]
    assert isinstance(part, Solutions) and [row.pattern for row in part] == [rows[i].pattern for i in (2, 4, 6)]
    with pytest.raises(IndexError):
        solutions[len(rows)]


def test_rows_that_were_solved_with_some_patterns(dataset: Path) -> None:
    solutions = load_solutions(dataset)
    patterns = {row.pattern for row in solutions if row.status == "solved"}
    assert len(patterns) > 1
    wanted = sorted(patterns)[:1]
    found = solutions.solved(wanted)
    assert [(row.task, row.pattern, row.cost) for row in found] == [
        (row.task, row.pattern, row.cost) for row in solutions if row.status == "solved" and row.pattern in wanted
    ]
    assert len(solutions.solved([])) == len(solutions.solved({"1111/1111"} - patterns)) == 0
    assert found.record == solutions.record


def test_frame_has_the_scalars(dataset: Path) -> None:
    frame = load_solutions(dataset).frame()
    assert isinstance(frame, pd.DataFrame)
    assert {"speed", "cycle_duration", "pattern", "status", "cost", "violation", "cpu_s"} <= set(frame.columns)
    assert frame["cost"].isna().sum() == (frame["status"] == "infeasible").sum() > 0


def test_a_damaged_or_foreign_file_is_refused_by_name(dataset: Path, tmp_path: Path) -> None:
    data = bytearray(dataset.read_bytes())
    data[len(data) // 2] ^= 1
    dataset.write_bytes(data)
    with pytest.raises(ValueError, match=r"solutions\.parquet: damaged"):
        load_solutions(dataset)
    other = tmp_path / "other.parquet"
    pq.write_table(pa.table({"x": [1]}), other)
    with pytest.raises(ValueError, match=r"other\.parquet: carries 0 seals"):
        load_solutions(other)
    with pytest.raises(FileNotFoundError, match="no such dataset"):
        load_solutions(tmp_path / "nothing")


def resealed(path: Path, table: pa.Table, record: dict[str, object]) -> Path:
    with open(path, "wb+") as file:
        write_sealed(file, table.schema, [table], record)
    return path


def replaced(table: pa.Table, name: str, values: pa.Array) -> pa.Table:
    return table.set_column(table.column_names.index(name), table.schema.field(name).with_type(values.type), values)


def test_what_is_sealed_and_yet_no_solutions_is_refused_by_name(dataset: Path, tmp_path: Path) -> None:
    solutions = load_solutions(dataset)
    table, record, rows = pq.read_table(dataset), solutions.record, len(solutions)
    odd = pa.field("split", pa.string(), True)
    patterns, base = pa.array(["01x/110"] * rows), table["base"].combine_chunks()
    infinite = pa.FixedSizeListArray.from_arrays(pa.array(np.full(rows * base.type.list_size, np.inf)), type=base.type)
    broken = {
        "columns differ: cost": table.drop_columns(["cost"]),
        "column cost is string": replaced(table, "cost", pa.array(["cheap"] * rows)),
        "split has rows without a value": table.set_column(
            table.column_names.index("split"), odd, pa.nulls(rows, pa.string())
        ),
        "a task is none of the scenario's: speed": replaced(table, "speed", pa.array([1e308] * rows)),
        "pattern: gait pattern '01x/110'": replaced(table, "pattern", patterns),
        "a row has a part of a motion": replaced(table, "feet", pa.nulls(rows, table.schema.field("feet").type)),
        "column base holds a number that is not finite": replaced(
            table, "base", pc.if_else(table["base"].is_valid(), infinite, pa.nulls(rows, base.type))
        ),
    }
    for fault, bad in broken.items():
        with pytest.raises(ValueError, match=f"bad.parquet: these are no solutions of its scenario: .*{fault}"):
            load_solutions(resealed(tmp_path / "bad.parquet", bad, record))
    for bad_record in (
        {key: value for key, value in record.items() if key != "scenario"},
        record | {"scenario": 3},
        record | {"scenario": record["scenario"] | {"robot": None}},
        record | {"scenario": record["scenario"] | {"transcription": {"phases": 4}}},
    ):
        with pytest.raises(ValueError, match=r"bad\.parquet: its record holds no scenario"):
            load_solutions(resealed(tmp_path / "bad.parquet", table, bad_record))


def test_a_link_out_of_the_folder_is_not_followed(dataset: Path, tmp_path: Path) -> None:
    (tmp_path / "1.0.0").mkdir()
    (tmp_path / "1.0.0" / "solutions.parquet").symlink_to(dataset)
    with pytest.raises(ValueError, match="leads out of"):
        load_solutions(tmp_path / "1.0.0")


def test_importing_the_package_loads_nothing_heavy() -> None:
    code = "import sys, gaitflow.dataset; print({'pyarrow', 'pandas', 'casadi', 'torch', 'dask'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
