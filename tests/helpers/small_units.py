"""A small planar scenario, its units, and solutions with arrays of its shapes."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.core.layout import Layout
from gaitflow.core.trajectory import Trajectory
from gaitflow.search.solution import Multipliers, Solution
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit, plan_units

PATTERNS = ("0110/1100", "0011/1001", "0101/0101")
Span = tuple[float, float, int]  # start, stop, count


def quickstart(checkout: Path, speeds: Span, cycles: Span, held_out: int, tasks_per_unit: int) -> Scenario:
    """The quickstart's scenario on a small grid."""
    data = load_scenario(checkout / "configs/scenarios/quickstart.yaml").as_data()
    spans = {"speed": speeds, "cycle_duration": cycles}
    axes = {axis: dict(zip(("start", "stop", "count"), span, strict=True)) for axis, span in spans.items()}
    data["tasks"] = {"axes": axes, "held_out": held_out}
    data["strategy"]["tasks_per_unit"] = tasks_per_unit
    return Scenario.from_data(data, "test")


@pytest.fixture(scope="session")
def scenario(checkout: Path) -> Scenario:
    """Quickstart with 3 speeds, 2 durations, 3 held-out tasks, chains of 2 tasks and 2 knots a phase."""
    small = quickstart(checkout, speeds=(0.1, 2.1, 3), cycles=(0.4, 1.2, 2), held_out=3, tasks_per_unit=2)
    return small.model_copy(update={"transcription": small.transcription.model_copy(update={"knots_per_phase": 2})})


@pytest.fixture(scope="session")
def units(scenario: Scenario) -> tuple[Unit, ...]:
    return plan_units(scenario)


@pytest.fixture
def store(tmp_path: Path) -> UnitStore:
    return UnitStore(tmp_path / "runs" / "test")


@pytest.fixture(scope="session")
def make_solutions() -> Callable[[Unit], list[Solution]]:
    """For every task three rows: a solved one, a dearer one of the same gait, and an infeasible one without arrays."""
    return solutions_of


def solutions_of(unit: Unit) -> list[Solution]:
    generator = np.random.default_rng(int(unit.digest[:8], 16))
    layout = Layout.of(unit.scenario.as_data())
    rows = []
    for task in unit.tasks:
        for i, pattern in enumerate(PATTERNS):
            row = Solution(
                task=task,
                pattern=pattern,
                gait=PATTERNS[0],
                strategy="patterns",
                start="nominal",
                seed=0,
                status="solved",
                solver_status="Solve_Succeeded",
                cost=100.0 * task.speed + i,
                refined_cost=99.0 * task.speed + i,
                refined_knots=4,
                violation=1e-9,
                iterations=20,
                solves=1,
                wall_s=0.1,
                cpu_s=float(generator.uniform()),
                trajectory=random_trajectory(generator, layout),
                multipliers=Multipliers(generator.normal(size=9), generator.normal(size=7)),
            )
            if i == 2:
                nothing = dict.fromkeys(("cost", "refined_cost", "violation"), math.nan)
                row = replace(row, status="infeasible", **nothing, refined_knots=0, trajectory=None, multipliers=None)
            rows.append(row)
    return rows


def random_trajectory(generator: np.random.Generator, layout: Layout) -> Trajectory:
    """Arrays of a layout's shapes that are no motion."""
    w = generator.normal(size=layout.nw)
    w[layout.fractions] = generator.uniform(size=layout.phases)
    return layout.unpack(w, 1.0)


def filled(
    store: UnitStore, units: tuple[Unit, ...], make_solutions: Callable[[Unit], list[Solution]], order_seed: int = 0
) -> UnitStore:
    """The store with solutions of all units, units and rows written in a random order."""
    for unit in random.Random(order_seed).sample(units, len(units)):
        rows = make_solutions(unit)
        random.Random(order_seed).shuffle(rows)
        store.write(unit, rows, {"tol": 1e-9})
    return store
