"""What the picks of a map in the making come to, once they are planned."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from gaitflow.atlas.border import find_borders
from gaitflow.atlas.fill import LIMIT
from gaitflow.certificate.judge import DEARER, Verdict, judge_picks, judge_plans
from gaitflow.core.task import Task
from gaitflow.dataset.labels import gait_costs
from gaitflow.runtime.atlas import SUPPORT, TRIED
from gaitflow.sampling.making import MapInMaking
from gaitflow.sampling.planning import Planning
from gaitflow.search.attempts import best_of, until_feasible
from gaitflow.solvers.fixed_gait import FixedGaitSolver

STARTS = 2  # nearest nodes of a pattern from which a pick is solved


@dataclass(frozen=True)
class Suspect:
    """A task whose pick, once planned, may be wrong.

    `gaits` are the numbers of the pick and of gaits of the map that may cost less. infeasible: the pick has no motion.
    missing: the numbers of gaits that the map does not pick from and that are predicted to cost less, each with the
    share of the pick's cost that it would save.
    """

    task: Task
    gaits: frozenset[int]
    infeasible: bool
    missing: Mapping[int, float] = field(default_factory=dict)

    @property
    def lacks_gait(self) -> bool:
        """Whether the map lacks a gait there: its pick has no motion, or another gait is missing."""
        return self.infeasible or bool(self.missing)


class Picks:
    """Plans and judges the gaits that a map in the making picks, at tasks of its domain."""

    def __init__(self, making: MapInMaking) -> None:
        self._making = making
        self._solver = FixedGaitSolver(making.problem, making.scenario.strategy.solve_time_limit)

    def judge(self, tasks: Sequence[Task], planning: Planning | None = None) -> list[Verdict]:
        """What the picks come to at tasks that were searched: the cheapest gaits, or those that a planning picks."""
        if not tasks:
            return []
        making, costs = self._making, self._searched(tasks)
        picks = dict(zip(tasks, self._of(tasks) if planning is None else planning.picks(tasks), strict=True))
        names = [making.gaits[pick] if pick >= 0 else "" for pick in picks.values()]
        return judge_picks(list(tasks), names, costs, lambda task: self._costs([task], [picks[task]])[0])

    def judge_plans(self, tasks: Sequence[Task], planning: Planning) -> list[Verdict]:
        """What plans come to at tasks that were searched."""
        if not tasks:
            return []
        gaits = self._making.gaits
        plans = [("", None) if plan is None else (gaits[plan.gait], plan.cost) for plan in planning.plans(tasks)]
        return judge_plans(tasks, plans, self._searched(tasks))

    def suspects(self, tasks: Sequence[Task]) -> list[Suspect]:
        """Of tasks that were not searched those whose pick may be wrong."""
        making, picks = self._making, self._of(tasks)
        atlas, picked, found = making.costs_atlas(), making.picked, []
        for task, pick, cost in zip(tasks, picks, self._costs(tasks, picks), strict=True):
            costs, support = atlas.costs(np.array(task.on(atlas.axes)))
            cheaper = costs * making.problem.cost_scale * (1 + DEARER) < (np.inf if cost is None else cost)
            rivals = {atlas.sheets[sheet].gait for sheet in np.flatnonzero(cheaper & (support >= TRIED))}
            missing: dict[int, float] = {}
            for sheet in np.flatnonzero(cheaper & (support >= SUPPORT)):
                gait = atlas.sheets[sheet].gait
                saving = 1.0 if cost is None else 1 - costs[sheet] * making.problem.cost_scale / cost
                if gait not in picked:
                    missing[gait] = max(float(saving), missing.get(gait, 0.0))
            if cost is None or rivals - {pick}:
                found.append(Suspect(task, frozenset((rivals & picked) | {pick}), cost is None, missing))
        return found

    def look_closely(self, suspects: Sequence[Suspect]) -> None:
        """Nodes of the suspected gaits at their tasks, or the borders before which their motions end."""
        making, ranged = self._making, self._making.scenario.tasks.ranges
        gaits = [(gait, one.task.on(ranged)) for one in suspects for gait in sorted(one.gaits)]
        with making.inside():
            find_borders(making.growth, [(sheet, place) for gait, place in gaits for sheet in making.sheets_of(gait)])
            making.growth.spread()

    def _searched(self, tasks: Sequence[Task]) -> pd.DataFrame:
        return gait_costs(self._making.scalars(tasks), self._making.scenario.robot.leg_names)

    def _of(self, tasks: Sequence[Task]) -> list[int]:
        """The number of the gait that the map picks at each task, -1 where its atlas knows none."""
        kept, atlas, picks = sorted(self._making.picked), self._making.picking_atlas(), []
        for task in tasks:
            ranked = atlas.ranked(np.array(task.on(atlas.axes)))
            picks.append(kept[atlas.sheets[ranked[0]].gait] if ranked else -1)
        return picks

    def _costs(self, tasks: Sequence[Task], picks: Sequence[int]) -> list[float | None]:
        """The least cost of a gait at each task, from its nearest nodes, else other starts; None without a motion."""
        making, growth = self._making, self._making.growth
        places = [task.on(making.scenario.tasks.ranges) for task in tasks]
        sheets = [making.sheets_of(pick) for pick in picks]
        found: dict[tuple[int, int], float] = {}
        for start in range(STARTS):
            asked = [
                (number, sheet)
                for number, each in enumerate(sheets)
                for sheet in each
                if (number, sheet) not in found and start < len(growth.nodes[sheet])
            ]
            requests = [
                (sheet, places[number], growth.nearest(sheet, places[number], start + 1)[start])
                for number, sheet in asked
            ]
            costs = growth.solver.costs_at(requests, LIMIT)
            found |= {
                at: cost * making.problem.cost_scale for at, cost in zip(asked, costs, strict=True) if cost is not None
            }
        return [
            min(known) if (known := [found[number, sheet] for sheet in each if (number, sheet) in found])
            else self._from_other_starts(each, task)
            for number, (task, each) in enumerate(zip(tasks, sheets, strict=True))
        ]  # fmt: skip

    def _from_other_starts(self, sheets: Sequence[int], task: Task) -> float | None:
        restarts, patterns = self._making.scenario.strategy.restarts, self._making.growth.solver.patterns
        tries = (best_of(until_feasible(self._solver, patterns[sheet], task, None, restarts)) for sheet in sheets)
        return min((best.cost for best in tries if best is not None), default=None)
