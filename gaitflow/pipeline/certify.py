"""A certificate for a published map: its plans at random tasks beside what the scenario's own search finds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from gaitflow.certificate.bound import chances_of, tasks_needed
from gaitflow.certificate.certificate import Certificate, certify
from gaitflow.certificate.draw import draw_tasks
from gaitflow.certificate.judge import Verdict, judge_picks, judge_plans
from gaitflow.config.file import ConfigError
from gaitflow.config.sampling import Sampling
from gaitflow.config.scenario import Scenario
from gaitflow.core.errors import ArtifactError
from gaitflow.core.task import Task
from gaitflow.dataset.labels import gait_costs
from gaitflow.execute.display import display
from gaitflow.execute.local import local_run_client
from gaitflow.execute.map_processes import Asked, Planned, plan_all
from gaitflow.execute.progress import countdown, progress
from gaitflow.execute.run import run_units
from gaitflow.files import make_folder
from gaitflow.pipeline.kept_plans import kept_plans
from gaitflow.pipeline.workspace import Workspace
from gaitflow.runtime import GaitMap
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import plan_cold
from gaitflow.tables.schema import scalar_columns, solution_schema

PLANNED_SEED = 10**12  # apart from the seeds of the searched tasks, and from those of a map's own certificate


def certify_map(
    workspace: Workspace, path: Path, workers: int, tasks: int | None, seed: int
) -> tuple[Certificate, list[Verdict], GaitMap]:
    """Search `tasks` random tasks of a map's domain cold, on `workers` processes, and judge its plans there.

    Returns the verdicts on the plans, too. By default as many tasks are searched as bound the dearer plans by 2 % when
    none fails; further ones are planned only, as many as bound those without a plan by 0.5 %. What is searched and
    planned is stored in runs/certify-NAME-VERSION: a certificate that was stopped goes on. Raises ArtifactError for a
    map that the installed code cannot plan or search for, EmptyDomain.
    """
    gait_map = GaitMap.load(path)
    scenario = _scenario_of(gait_map)
    middle: dict[str, Any] = gait_map.manifest.domain.middle
    gait_map.plan(**middle)  # raises here what would come up after hours of searching
    goal, (chance_dearer, chance_infeasible) = Sampling(), chances_of(1)
    number = tasks_needed(0, goal.dearer, chance_dearer) if tasks is None else tasks
    domain, space = gait_map.manifest.domain, scenario.tasks.space
    drawn = draw_tasks(domain, space, number, seed, "held_out")
    costs = _searched(workspace, gait_map, scenario, drawn, workers)
    further = max(tasks_needed(0, goal.infeasible, chance_infeasible) - number, 0)
    planned = draw_tasks(domain, space, further, PLANNED_SEED + seed, "held_out")
    with display(f"plans of {gait_map.manifest.name} {gait_map.manifest.version}") as tell:
        asked: list[Asked] = [(_values(gait_map, task), None) for task in [*drawn, *planned]]
        on_plan, file = countdown(tell, "plans"), _folder(workspace, gait_map) / f"plans-{seed}.jsonl"
        with kept_plans(file, gait_map.manifest, asked) as kept:
            left = asked[len(kept.plans) :]
            plan_all(path, left, workers, lambda plan: on_plan(kept.add(plan), len(left)))
        found = kept.plans
        plans = judge_plans(drawn, [(_key(gait_map, gait), cost) for gait, cost in found[:number]], costs)
        selections = _judged_picks(gait_map, drawn, costs, lambda picked: plan_all(path, picked, workers))
    have_plans = [cost is not None for _, cost in found[number:]]
    return certify(plans, selections, have_plans, 1, seed), plans, gait_map


def _scenario_of(gait_map: GaitMap) -> Scenario:
    manifest = gait_map.manifest
    try:
        return Scenario.from_data(dict(manifest.scenario), f"{manifest.name} {manifest.version}")
    except ConfigError as error:
        raise ArtifactError(
            f"its scenario cannot be searched by the gaitflow that is installed: {error}; use the version that `code` "
            "in its manifest names"
        ) from None


def _searched(
    workspace: Workspace, gait_map: GaitMap, scenario: Scenario, tasks: Sequence[Task], workers: int
) -> pd.DataFrame:
    manifest, folder = gait_map.manifest, _folder(workspace, gait_map)
    make_folder(folder)
    store = UnitStore(folder)
    units = plan_cold(scenario, tasks)
    with progress(f"certificate of {manifest.name} {manifest.version}") as on_event:
        run_units(units, store, lambda: local_run_client(store.folder, workers), on_event)
    columns = scalar_columns(solution_schema(scenario.as_data()).names)
    rows = pd.concat([store.read(unit, columns=columns).to_pandas() for unit in units], ignore_index=True)
    return gait_costs(rows, scenario.robot.leg_names)


def _folder(workspace: Workspace, gait_map: GaitMap) -> Path:
    return workspace.root / "runs" / f"certify-{gait_map.manifest.name}-{gait_map.manifest.version}"


def _values(gait_map: GaitMap, task: Task) -> dict[str, Any]:
    return {axis: task[axis] for axis in gait_map.axes}


def _judged_picks(
    gait_map: GaitMap, tasks: Sequence[Task], costs: pd.DataFrame, plan: Callable[[Sequence[Asked]], Sequence[Planned]]
) -> list[Verdict]:
    """Verdicts on what `select` names; `plan` is asked for all picks at once that the search's own motions fail."""
    names = [str(gait_map.select(**_values(gait_map, task)).gait) for task in tasks]
    picks = [_key(gait_map, name) for name in names]
    by_search = judge_picks(tasks, picks, costs, lambda task: None)
    dear = {
        verdict.task: (_values(gait_map, verdict.task), name)
        for verdict, name in zip(by_search, names, strict=True)
        if verdict.dearer
    }
    planned = dict(zip(dear, plan(list(dear.values())), strict=True))
    return judge_picks(tasks, picks, costs, lambda task: planned[task][1])


def _key(gait_map: GaitMap, name: str) -> str:
    return next(gait.key for gait in gait_map.gaits if gait.name == name)
