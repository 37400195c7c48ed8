"""The gaits of each task from the cheapest on, with what each asks of the robot: is the choice clear, is it close?

Answers section IV.C's hardware trial (0.3 m/s, 0.8 s): which gait comes out under the robot's limits, by what margin.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.document import document
from benchmarks.rows import Row
from benchmarks.search.tasks import task_of
from gaitflow.config.scenario import Scenario
from gaitflow.core.check import violations
from gaitflow.core.gaits import Pattern
from gaitflow.core.names import gait_kind
from gaitflow.dataset.labels import gait_costs
from gaitflow.dataset.read import Solutions
from gaitflow.search.solution import Solution
from gaitflow.tables.schema import task_columns

SHOWN = 12  # gaits of a task
NOTES = (
    "margin_rel: how much dearer than the task's cheapest gait. Costs of one gait are those of its best pattern.",
    "peak_force_share, peak_speed_share: the largest normal force and foot speed over the robot's limits; 1 means that "
    "a limit is active. duty: share of the cycle that each leg stands, in the robot's order of legs.",
    "violation: worst scaled constraint violation by the independent check.",
)


def run(scenario: Scenario, solutions: Solutions) -> Row:
    """The document: a row a task and gait, cheapest first, at most SHOWN a task."""
    costs = gait_costs(solutions.frame(), scenario.robot.leg_names)
    motions = {(row.task, row.pattern): row for row in solutions if row.trajectory is not None}
    axes = scenario.tasks.space.columns
    rows: list[Row] = []
    for _, task in costs.groupby(task_columns(costs.columns), sort=False):
        best = float(task["cost"].iloc[0])
        for rank, gait in enumerate(task.head(SHOWN).to_dict("records"), start=1):
            row = motions[task_of(scenario, gait, gait["split"]), gait["pattern"]]
            rows.append(
                {key: gait[key] for key in (*axes, "gait", "pattern", "cost")}
                | {"rank": rank, "margin_rel": float(gait["cost"]) / best - 1}
                | asked(scenario, row)
            )
    return document("ranking", scenario.name, rows, summarise(rows, axes, scenario.robot.leg_names), NOTES)


def asked(scenario: Scenario, row: Solution) -> Row:
    """What a motion asks of the robot, and whether it stands."""
    trajectory = row.trajectory
    assert trajectory is not None
    contacts = np.array([[float(digit) for digit in leg] for leg in row.pattern.split("/")])
    found = violations(scenario.as_data(), trajectory, row.task, row.pattern)
    return {
        "peak_force_share": float(trajectory.forces[..., -1].max()) / scenario.robot.max_force,
        "peak_speed_share": float(np.abs(trajectory.foot_velocities).max()) / scenario.robot.max_foot_speed,
        "duty": (contacts @ trajectory.durations / row.task.cycle_duration).tolist(),
        "violation": max(found.values()),
    }


def summarise(rows: Sequence[Row], axes: Sequence[str], leg_names: Sequence[str]) -> dict[str, Any]:
    """How many tasks, by their axes, the kinds of gait that win, and the least margin to another *kind* of gait."""
    frame = pd.DataFrame(rows)
    kinds = [_kind(text, leg_names) for text in frame["pattern"]] if len(frame) else []
    frame = frame.assign(kind=kinds)
    winners, margins = [], []
    for _, task in frame.groupby(list(axes), sort=False):
        winners.append(task["kind"].iloc[0])
        others = task.loc[task["kind"] != winners[-1], "margin_rel"]
        margins.append(float(others.min()) if len(others) else None)
    known = [margin for margin in margins if margin is not None]
    return {
        "tasks": len(winners),
        "kinds": {str(kind): winners.count(kind) for kind in dict.fromkeys(winners)},
        "margin_to_other_kind_min_rel": min(known, default=None),
        "margin_to_runner_up_min_rel": min((row["margin_rel"] for row in rows if row["rank"] == 2), default=None),
        "worst_violation": max((row["violation"] for row in rows), default=None),
    }


def _kind(pattern: str, leg_names: Sequence[str]) -> str:
    return gait_kind(Pattern.from_text(pattern), leg_names)
