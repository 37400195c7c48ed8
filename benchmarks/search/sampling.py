"""How many searches a map needs: chosen where it is least sure, and on uniform grids, judged at the same fresh tasks.

Every map is made from its searched tasks in the same way, from nothing, and asked for its pick at the tasks of the
adaptive map's certificate, which had no part in any of them.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial
from itertools import chain
from math import prod
from pathlib import Path
from typing import Any

from benchmarks.document import document
from benchmarks.rows import Row, RowStore
from gaitflow.certificate.bound import CONFIDENCE, upper_bound
from gaitflow.config.axes import Range
from gaitflow.config.scenario import Scenario
from gaitflow.config.tasks import grid_of
from gaitflow.core.task import Task
from gaitflow.execute.display import display
from gaitflow.execute.node_processes import node_processes
from gaitflow.pipeline.drive import drive
from gaitflow.pipeline.json_file import read_json
from gaitflow.pipeline.sampling import sample
from gaitflow.pipeline.searched import motions_of, scalars_of
from gaitflow.pipeline.workspace import Run
from gaitflow.sampling.making import MapInMaking
from gaitflow.sampling.picks import Picks
from gaitflow.sampling.rounds import held_out, rounds_from, task_at
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import plan_cold
from gaitflow.tables.solutions import table_to_solutions

WORKERS = 2
FINENESS = (0.25, 0.4, 0.55, 0.75, 1.0)  # of the grids, relative to the scenario's own, until one has no dearer pick
NOTES = (
    "searched: the tasks that a map is made from. judged: fresh tasks inside its domain. dearer: at how many of them "
    "its pick costs more than 1 % above the best that a search finds, or has no motion. bound: the share of the "
    "domain's tasks with a dearer pick, at most, with 95 % confidence (Clopper and Pearson, of this row alone).",
    "All maps are made alike: gaits spread over the scenario's grid by continuation, and get nodes where the pick is "
    "not the search's. Published maps have nodes where predictions fail, too, which take longer than these searches.",
)


def run(scenario: Scenario, run: Run, runs: Path) -> Row:
    """The document: a row a map. What was searched, and the rows, are kept below `runs`.

    `run` is the scenario's: where it has been sampled, its searches are taken over. A scenario with a grid is sampled
    first, as it is but for that.
    """
    own = Run(runs / "bench" / f"sampling-{scenario.name}")
    own.folder.mkdir(parents=True, exist_ok=True)
    adaptive = _adaptive(scenario)
    store, rows = UnitStore(own.folder), RowStore("sampling", adaptive, runs, [sys.modules[__name__]])
    with display(f"sampling {scenario.name}") as tell, node_processes(adaptive, WORKERS) as each:
        search = partial(_search, adaptive, store, UnitStore(run.folder), tell)
        source = run if scenario.tasks.adaptive is not None and run.sampled_record.exists() else own
        rounds = (
            rounds_from(read_json(run.rounds), scenario.tasks.space)
            if source is run
            else sample(own, adaptive, search, tell, each)
        )
        judges = sorted(held_out(rounds))
        search(judges)
        chosen = [one.tasks for one in rounds if not set(one.tasks) <= set(judges)]
        steps = [tuple(chain.from_iterable(chosen[: number + 1])) for number in range(len(chosen))]
        grids = [("grid", _grid(adaptive, fine)) for fine in FINENESS]
        maps = [*grids, *(("adaptive", tasks) for tasks in _doubling(steps))]
        tasks_of = {(way, len(tasks)): tasks for way, tasks in maps}

        def judged(key: Row) -> Row:
            tasks = tasks_of[key["way"], key["searched"]]
            search(tasks)
            making = MapInMaking(adaptive, scalars_of(store, adaptive), motions_of(store, adaptive), tell, each)
            return _judged(making, tasks, judges)

        made = list[Row]()
        for way, searched in tasks_of:
            if way == "adaptive" or not any(row["dearer"] == 0 for row in made):  # a finer grid would add nothing
                made += rows.rows([{"way": way, "searched": searched}], judged)
    return document("sampling", scenario.name, made, _summary(made), NOTES)


def _doubling(steps: Sequence[tuple[Task, ...]]) -> list[tuple[Task, ...]]:
    """The first of growing sets of tasks, those that are twice as many as the one before, and the last."""
    taken = [steps[0]]
    for tasks in steps[1:]:
        if len(tasks) >= 2 * len(taken[-1]) or tasks is steps[-1]:
            taken.append(tasks)
    return taken


def _adaptive(scenario: Scenario) -> Scenario:
    if scenario.tasks.adaptive is not None:
        return scenario
    tasks = {key: value for key, value in scenario.tasks.as_data().items() if key == "axes"} | {"sampling": "adaptive"}
    return scenario.model_copy(update={"tasks": scenario.tasks.from_data(tasks, scenario.name)})


def _search(scenario: Scenario, store: UnitStore, known: UnitStore, tell: Any, tasks: Sequence[Task]) -> None:
    """Have tasks searched that neither the bench nor the scenario's own run has searched."""
    units = plan_cold(scenario, tasks)
    for unit in units:
        if not store.has(unit) and known.has(unit):
            store.write(unit, list(table_to_solutions(known.read(unit), scenario.as_data())), {})
    drive(units, store, tell, WORKERS, None)


def _grid(scenario: Scenario, fineness: float) -> tuple[Task, ...]:
    """A uniform grid over the scenario's ranges."""
    ranges = {
        axis: Range(start=of.start, stop=of.stop, count=max(round(1 + (of.count - 1) * fineness), 2))
        for axis, of in scenario.tasks.ranges.items()
    }
    tasks = scenario.tasks.as_data()
    axes = tasks["axes"] | {axis: of.as_data() for axis, of in ranges.items()}
    coarse = scenario.model_copy(
        update={"tasks": scenario.tasks.from_data({"axes": axes, "sampling": "adaptive"}, scenario.name)}
    )
    assert len(grid_of(coarse)) == prod(of.count for of in ranges.values())
    space = scenario.tasks.space
    return tuple(task_at(space, task.on(space.ranged)) for task in grid_of(coarse))


def _judged(making: MapInMaking, tasks: Sequence[Task], judges: Sequence[Task]) -> Row:
    """One map: made from searched tasks, and its picks at others."""
    making.take(tasks, [])
    making.settle()
    inside = [task for task in judges if making.domain.contains(task)]
    dearer = sum(verdict.dearer for verdict in Picks(making).judge(inside))
    return {
        "judged": len(inside),
        "dearer": dearer,
        "bound": upper_bound(dearer, len(inside), 1 - CONFIDENCE) if inside else 1.0,
        "gaits": len(making.labelled),
        "nodes": sum(map(len, making.growth.nodes)),
    }


def _summary(rows: Sequence[Row]) -> Row:
    """The fewest searches by which each way reached the bound of the last adaptive map."""
    goal = [row for row in rows if row["way"] == "adaptive"][-1]["bound"]
    fewest = {
        way: min((row["searched"] for row in rows if row["way"] == way and row["bound"] <= goal), default=None)
        for way in ("adaptive", "grid")
    }
    return {"bound": goal, **{f"searched_{way}": searched for way, searched in fewest.items()}}
