"""The motions that a map plans, to be shown as stored ones are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from gaitflow.config.scenario import Scenario
from gaitflow.core.trajectory import Trajectory
from gaitflow.report.predicted import known_gaits
from gaitflow.report.stored import Ranked, Shown, chosen
from gaitflow.runtime import GaitMap, OutOfDomain
from gaitflow.runtime.artifact import load_artifact
from gaitflow.search.solution import Solution


def of_map(folder: Path, values: Mapping[str, float], gait: str | None = None) -> Shown:
    """The gaits of a map at a task with their predicted costs, each with the motion that `GaitMap.plan` makes of it.

    They are in the order in which the map takes them. The first one shown is the gait that `plan` takes, which need not
    be the first of these.

    A cycle duration that is left out is the map's choice, for `gait` when that is given. Raises ValueError for a task
    that the map cannot be asked for or does not answer, ArtifactError when it cannot be read or does not plan.
    """
    artifact = load_artifact(folder)
    gait_map, manifest = GaitMap(artifact), artifact.manifest
    asked: dict[str, Any] = dict(values)
    try:
        choice = gait_map.select(**asked) if gait is None else gait_map.plan(gait=gait, **asked)
    except OutOfDomain as error:
        raise ValueError(str(error)) from None
    task = manifest.space.task({axis: choice.task[axis] for axis in gait_map.axes})
    if not choice.in_domain:
        raise ValueError(manifest.domain.explain(task))
    known = known_gaits(artifact, choice.task)
    ranked = tuple(Ranked(n, one.gait, one.pattern, one.cost, True, -1) for n, one in enumerate(known, start=1))
    scenario = Scenario.from_data(dict(manifest.scenario), f"{manifest.name} {manifest.version}")

    place: dict[str, Any] = {axis: choice.task[axis] for axis in gait_map.axes}

    def motion(one: Ranked) -> Solution:
        plan = gait_map.plan(gait=one.gait, **place)
        if not plan.feasible:
            raise ValueError(
                f"{one.gait}: no feasible motion at this task; worst violation {plan.violation:.1e}; without --gait "
                "and --rank the gait is drawn that has one"
            )
        return Solution(
            task=task,
            pattern=plan.pattern,
            gait=next(each.key for each in gait_map.gaits if each.name == one.gait),
            strategy="plan",
            start="atlas",
            seed=0,
            status="solved",
            solver_status=plan.path,
            cost=plan.cost,
            violation=plan.violation,
            iterations=plan.iterations,
            trajectory=Trajectory(**{field.name: getattr(plan, field.name) for field in fields(Trajectory)}),
        )

    return Shown("task", scenario, task, ranked, motion, lambda: chosen(ranked, gait_map.plan(**place).gait, None))
