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
from gaitflow.execute.local import local_run_client
from gaitflow.execute.progress import progress
from gaitflow.execute.run import run_units
from gaitflow.files import make_folder
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
    none fails; further ones are planned only, as many as bound those without a plan by 0.5 %. What is searched is
    stored in runs/certify-NAME-VERSION: a certificate that was stopped goes on. Raises ArtifactError for a map that the
    installed code cannot plan or search for, EmptyDomain.
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
    plans = judge_plans(drawn, [_planned(gait_map, task) for task in drawn], costs)
    selections = judge_picks(drawn, [_pick(gait_map, task) for task in drawn], costs, _cost_of_pick(gait_map))
    further = max(tasks_needed(0, goal.infeasible, chance_infeasible) - number, 0)
    planned = draw_tasks(domain, space, further, PLANNED_SEED + seed, "held_out")
    have_plans = [_planned(gait_map, task)[1] is not None for task in planned]
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
    manifest = gait_map.manifest
    folder = workspace.root / "runs" / f"certify-{manifest.name}-{manifest.version}"
    make_folder(folder)
    store = UnitStore(folder)
    units = plan_cold(scenario, tasks)
    with progress(f"certificate of {manifest.name} {manifest.version}") as on_event:
        run_units(units, store, lambda: local_run_client(store.folder, workers), on_event)
    columns = scalar_columns(solution_schema(scenario.as_data()).names)
    rows = pd.concat([store.read(unit, columns=columns).to_pandas() for unit in units], ignore_index=True)
    return gait_costs(rows, scenario.robot.leg_names)


def _values(gait_map: GaitMap, task: Task) -> dict[str, Any]:
    return {axis: task[axis] for axis in gait_map.axes}


def _planned(gait_map: GaitMap, task: Task) -> tuple[str, float | None]:
    plan = gait_map.plan(**_values(gait_map, task))
    return _key(gait_map, plan.gait), plan.cost if plan.feasible else None


def _pick(gait_map: GaitMap, task: Task) -> str:
    return _key(gait_map, gait_map.select(**_values(gait_map, task)).gait)


def _key(gait_map: GaitMap, name: str | None) -> str:
    return next(gait.key for gait in gait_map.gaits if gait.name == name)


def _cost_of_pick(gait_map: GaitMap) -> Callable[[Task], float | None]:
    def cost(task: Task) -> float | None:
        values = _values(gait_map, task)
        plan = gait_map.plan(gait=gait_map.select(**values).gait, **values)
        return plan.cost if plan.feasible else None

    return cost
