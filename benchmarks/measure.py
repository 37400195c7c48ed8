"""The benches by name, each with the files it reads."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.clients import drive, starts, walk
from benchmarks.hostile import bench as hostile
from benchmarks.infrastructure import faults, overhead, scale, speedup, store
from benchmarks.online import certify, cpp, map, online, select, speed
from benchmarks.paper import discovery, minlp, phases, ranking, stances, table1, table2
from benchmarks.search import certificate, mesh, referee, sampling, scaling
from benchmarks.search.tasks import gridded, task_of
from gaitflow.config.cluster import Profile
from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Task
from gaitflow.dataset import load_solutions
from gaitflow.pipeline.earlier import need
from gaitflow.pipeline.workspace import Workspace
from gaitflow.report.map_tasks import newest_grid
from gaitflow.runtime.versions import resolve
from gaitflow.store.journal import read_journal


def measure(
    name: str,
    workspace: Workspace,
    scenario: Scenario,
    tasks: int | None,
    seed: int,
    profile: Profile | None = None,
) -> dict[str, Any]:
    """Run one bench and return its document; `tasks` None takes the bench's own number.

    `tasks` is for `scaling` the solves a size, for `referee` the solved patterns, for `store` and `scale` the largest
    plan. With a `profile`, `speedup` runs on the jobs of that cluster; no other bench takes one. Benches of
    grid tasks take the scenario's grid also where its map chooses its tasks.

    Raises ValueError, FileNotFoundError or StageMissing when what a bench reads (a run, a published map) is not there,
    ValueError also for a profile where there can be none.
    """
    if profile is not None and name != "speedup":
        raise ValueError(f"bench {name} runs on this machine; a profile is for `bench speedup` only")
    runs, grid = workspace.root / "runs", gridded(scenario)
    own: dict[str, Any] = {} if tasks is None else {"tasks": tasks}
    benches: dict[str, Callable[[], dict[str, Any]]] = {
        "certificate": lambda: certificate.run(
            grid, _grid_labels(workspace, scenario), seed=seed, runs=runs, **own
        ),
        "certify": lambda: certify.run(workspace, resolve(workspace.models / scenario.name), tasks, seed),
        "clients": lambda: starts.run(resolve(workspace.models / scenario.name), seed=seed, **own),
        "cpp": lambda: cpp.run(resolve(workspace.models / scenario.name), seed=seed, **own),
        "discovery": lambda: discovery.run(
            grid, seed=seed, runs=runs, map_cpu_s=_map_cpu(workspace, scenario), **own
        ),
        "drive": lambda: drive.run(resolve(workspace.models / scenario.name), seed=seed, **own),
        "faults": partial(faults.faults, scenario, tasks or 12, 20, seed),
        "hostile": lambda: hostile.run(Path(__file__).parents[1], seed=seed, tasks=tasks),
        "map": partial(_map, workspace, scenario),
        "mesh": lambda: mesh.run(grid, seed=seed, runs=runs, **own),
        "minlp": lambda: minlp.run(grid, seed=seed, runs=runs, **own),
        "online": lambda: online.run(
            scenario, resolve(workspace.models / scenario.name), seed=seed, runs=runs, **own
        ),
        "overhead": lambda: overhead.run(scenario, runs=runs, **own),
        "phases": partial(_phases, workspace, scenario),
        "ranking": lambda: ranking.run(scenario, load_solutions(workspace.run(scenario).solutions)),
        "referee": lambda: referee.run(grid, seed=seed, runs=runs, **own),
        "sampling": lambda: sampling.run(scenario, workspace.run(scenario), runs),
        "scale": lambda: scale.run(scenario, runs=runs, **own),
        "scaling": partial(_scaling, workspace, tasks or 10, seed),
        "select": lambda: select.run(resolve(workspace.models / scenario.name), seed=seed),
        "speed": lambda: speed.run(workspace.models, seed=seed, runs=runs, **own),
        "speedup": lambda: speedup.run(scenario, profile=profile, runs=runs, **own),
        "stances": partial(_stances, workspace, scenario),
        "store": lambda: store.run(scenario, runs=runs, **own),
        "table1": lambda: table1.run(grid, resolve(workspace.models / scenario.name), seed=seed, runs=runs, **own),
        "table2": lambda: table2.run(
            grid, resolve(workspace.models / scenario.name), _document(workspace, "minlp", scenario), seed=seed,
            runs=runs, **own,
        ),
        "walk": lambda: walk.run(
            scenario, resolve(workspace.models / scenario.name), seed=seed, runs=runs, **own
        ),
    }  # fmt: skip
    return benches[name]()


def _map(workspace: Workspace, scenario: Scenario) -> dict[str, Any]:
    run = workspace.run(scenario)
    journal = read_journal(run.folder / "journal")
    return map.run(scenario, load_solutions(run.solutions), pd.read_parquet(run.labels), journal)


def _grid_labels(workspace: Workspace, scenario: Scenario) -> pd.DataFrame:
    """The labels of a scenario's grid: its run's, or of the newest published grid where its map chooses its tasks."""
    if scenario.tasks.adaptive is None:
        labels = workspace.run(scenario).labels
        need(labels, f"gaitflow label {scenario.name}")
        return pd.read_parquet(labels)
    newest = newest_grid(workspace.datasets / scenario.name)
    if newest is None:
        raise ValueError(
            f"{scenario.name}: its map chooses its tasks and no dataset of it in {workspace.datasets} has a grid, as "
            "this bench needs; write `sampling: grid` in a copy of the scenario, and run that"
        )
    return newest[1]


def _document(workspace: Workspace, bench: str, scenario: Scenario) -> dict[str, Any] | None:
    """What another bench wrote on a scenario, if it has run."""
    path = workspace.results / f"{bench}-{scenario.name}.json"
    return json.loads(path.read_bytes()) if path.exists() else None


def _map_cpu(workspace: Workspace, scenario: Scenario) -> dict[Task, float]:
    """CPU seconds of solver calls that each grid task took in the scenario's run; empty when it was not run."""
    run = workspace.run(scenario)
    if not run.solutions.exists():
        return {}
    frame = load_solutions(run.solutions).frame()
    axes = list(scenario.tasks.space.columns)
    spent = frame[frame["split"] == "grid"].groupby(axes, as_index=False)[["cpu_s"]].sum()
    return {task_of(scenario, row): float(row["cpu_s"]) for row in spent.to_dict("records")}


def _scaling(workspace: Workspace, solves: int, seed: int) -> dict[str, Any]:
    scenarios = [workspace.scenario(name) for name in scaling.SCENARIOS]
    maps = {each.name: done["summary"] for each in scenarios if (done := _document(workspace, "map", each))}
    per_task = {name: told["cpu_s"] / told["labelled"] for name, told in maps.items() if told["labelled"]}
    return scaling.run(scenarios, solves=solves, seed=seed, runs=workspace.root / "runs", map_cpu_s=per_task)


def _stances(workspace: Workspace, scenario: Scenario) -> dict[str, Any]:
    free = workspace.scenario(f"{scenario.name}-free")
    labels, free_labels = (_grid_labels(workspace, each) for each in (scenario, free))
    return stances.run(scenario, free, labels, free_labels)


def _phases(workspace: Workspace, more: Scenario) -> dict[str, Any]:
    """`more` is named after the scenario that it extends: "anymal-flat-vibration-eight-phases"."""
    base = re.match(r"(.+?)-[a-z0-9]+-phases", more.name)
    if base is None:
        raise ValueError(f"{more.name}: must be named <scenario>-<number>-phases after the scenario to compare with")
    scenario = workspace.scenario(base[1])
    labels, more_labels = (_grid_labels(workspace, each) for each in (scenario, more))
    control = workspace.run(workspace.scenario(f"{scenario.name}-short-phases")).labels
    return phases.run(scenario, more, labels, more_labels, pd.read_parquet(control) if control.exists() else None)
