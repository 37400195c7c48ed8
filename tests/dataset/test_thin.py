from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from small_units import filled

from gaitflow.config.scenario import Scenario
from gaitflow.dataset import load_solutions
from gaitflow.dataset import thin as module
from gaitflow.dataset.collect import collect
from gaitflow.dataset.labels import gait_costs
from gaitflow.dataset.thin import thin
from gaitflow.search.solution import Solution
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit
from gaitflow.tables.schema import HEAVY

Make = Callable[[Unit], list[Solution]]


def test_published_size_keeps_trajectories_of_the_cheapest_gaits(
    store: UnitStore,
    scenario: Scenario,
    units: tuple[Unit, ...],
    make_solutions: Make,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    collected = collect(filled(store, units, make_solutions), scenario)
    monkeypatch.setattr(module, "ROWS_AT_ONCE", 5)
    whole = load_solutions(collected)
    costs = gait_costs(whole.frame(), scenario.robot.leg_names)
    small = load_solutions(thin(collected, store.folder / "small.parquet", costs, gaits=1, dearer=0.0))
    assert small.record == whole.record
    pd.testing.assert_frame_equal(whole.frame(), small.frame())
    for _, rows in small.frame().groupby(["split", "cycle_duration", "speed"]):
        kept = [i for i in rows.index if small[i].trajectory is not None]
        assert kept == [rows[rows["status"] == "solved"]["cost"].idxmin()]
        assert small[kept[0]].multipliers is not None
        assert (small[kept[0]].feet == whole[kept[0]].feet).all()
    arrays = [name for name in small.table.column_names if name in HEAVY]
    assert small.table.select(arrays).nbytes < whole.table.select(arrays).nbytes


def test_motions_are_kept_near_the_best_and_multipliers_to_three_digits(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    def two_gaits(unit: Unit) -> list[Solution]:
        return [replace(row, gait=row.pattern) for row in make_solutions(unit)]

    collected = collect(filled(store, units, two_gaits), scenario)
    whole = load_solutions(collected)
    costs = gait_costs(whole.frame(), scenario.robot.leg_names)
    small = load_solutions(thin(collected, store.folder / "small.parquet", costs, gaits=2, dearer=0.05))
    # Costs are 100 v and 100 v + 1: within 5 % at 1.1 m/s and above, not at 0.1 m/s.
    least = [task.speed for unit in units for task in unit.tasks]
    kept = [row.task.speed for row in small if row.multipliers is not None]
    assert len(kept) == sum(1 + (speed >= 0.2) for speed in least)
    assert kept == [row.task.speed for row in small if row.trajectory is not None]
    index = next(index for index, row in enumerate(small) if row.multipliers is not None)
    before, after = whole[index].multipliers, small[index].multipliers
    assert before is not None and after is not None
    assert np.allclose(after.rows, before.rows, rtol=2.0**-11, atol=0) and after.rows.dtype == np.float64
    assert (after.rows != before.rows).any() and (after.rows == after.rows.astype(np.float16)).all()


def test_a_damaged_dataset_is_not_thinned(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    collected = collect(filled(store, units, make_solutions), scenario)
    collected.write_bytes(collected.read_bytes()[:-50])
    with pytest.raises(ValueError, match="truncated"):
        thin(collected, store.folder / "small.parquet", pd.DataFrame(), gaits=1, dearer=0.1)
    assert not (store.folder / "small.parquet").exists()


def test_of_each_best_gait_a_share_of_the_tasks_counts() -> None:
    best = ["walk"] * 10 + ["trot"] * 3 + ["pace"]
    rows = [
        (0.1 * number, 0.5, "sampled", gait, excess)
        for number, name in enumerate(best)
        for gait, excess in ((name, 0.0), ("bound", 0.1))
    ]
    costs = pd.DataFrame(rows, columns=["speed", "cycle_duration", "split", "gait_key", "excess"])
    some = module._of_some_tasks(costs, 0.3)
    left = some[some["excess"] == 0]["gait_key"].value_counts().to_dict()
    assert left == {"walk": 3, "trot": 1, "pace": 1}
    assert some.groupby("speed").size().eq(2).all(), "all gaits of a task, or none"
    pd.testing.assert_frame_equal(module._of_some_tasks(costs, 1.0), costs)
    pd.testing.assert_frame_equal(module._of_some_tasks(costs, 0.3), some)
