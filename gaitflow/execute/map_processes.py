"""Processes that plan with a published map side by side, each with a copy of its own."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from gaitflow.execute.spawn import processes
from gaitflow.runtime import GaitMap

Asked = tuple[Mapping[str, Any], str | None]  # values by axis, and the gait to plan, None for the map's own choice
Planned = tuple[str, float | None]  # the plan's gait and its cost, None of a plan that is not feasible


def plan_all(
    path: Path, asked: Sequence[Asked], workers: int, on_plan: Callable[[Planned], None] = lambda plan: None
) -> list[Planned]:
    """The plans of the map at `path`, by so many processes; of one worker by this process.

    `on_plan` hears each as it comes. They are those of a call in this process, to the last bit.
    """
    plan, plans = functools.partial(_planned, path), list[Planned]()
    if workers == 1 or len(asked) < 2:
        for one in asked:
            plans.append(plan(one))
            on_plan(plans[-1])
        return plans
    with processes(workers) as calls:
        for each in calls(plan, asked):
            plans.append(each)
            on_plan(each)
    return plans


def _planned(path: Path, asked: Asked) -> Planned:
    values, gait = asked
    plan = _map(path).plan(gait=gait, **values)
    return plan.gait, plan.cost if plan.feasible else None


@functools.lru_cache(maxsize=1)
def _map(path: Path) -> GaitMap:
    return GaitMap.load(path)
