from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.infrastructure.overhead import cycle_s, run
from gaitflow.config.scenario import Scenario
from gaitflow.store.journal import Entry


def stored(solver: str, *times: float) -> list[Entry]:
    starts = [Entry("start", f"{solver}{time}", time - 0.5, solver) for time in times]
    return starts + [Entry("stored", f"{solver}{time}", time, solver, 0.1, 0.5, True) for time in times]


def test_a_cycle_goes_from_stored_to_stored_in_one_process() -> None:
    assert cycle_s(stored("a", 1.0, 2.5, 3.0) + stored("b", 7.0, 8.0)) == pytest.approx(3.0 / 3)
    with pytest.raises(ValueError, match="measure more tasks"):
        cycle_s(stored("a", 1.0) + stored("b", 9.0))


@pytest.mark.slow
def test_a_row_a_kind_and_number_of_workers_and_nobody_loads_torch(scenario: Scenario, tmp_path: Path) -> None:
    done = run(scenario, 40, tmp_path)
    assert [(row["solver"], row["workers"], row["units"]) for row in done["rows"]] == [
        ("no_time", 1, 40), ("no_time", 2, 40), ("one_second", 1, 4), ("one_second", 2, 4),
    ]  # fmt: skip
    summary = done["summary"]
    assert 0 < summary["overhead_ms_no_time"] < 5000 and summary["workers"] == 2
    assert summary["overhead_share"] == pytest.approx(summary["overhead_ms_one_second"] / 1e4)
    assert 0 < summary["later_unit_s"] < summary["solver_start_s"] < 60 and 0 < summary["first_solve_s"] < 60
    # What learns and what draws stays out of both processes; CasADi comes with the first solve, and there was none.
    learning = {"torch", "sklearn", "skorch", "matplotlib", "onnxruntime", "snakemake"}
    assert "pyarrow" in summary["solver_imports"] and not learning & set(summary["solver_imports"])
    assert not {"dask", "casadi"} & set(summary["solver_imports"])
    assert "dask" in summary["worker_imports"] and not learning & set(summary["worker_imports"])
    assert "casadi" not in summary["worker_imports"]
    assert list((tmp_path / "bench").iterdir()) == []
    json.dumps(done, allow_nan=False)
