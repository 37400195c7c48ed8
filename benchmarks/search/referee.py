"""IPOPT as the referee of the interior point that makes maps: the same patterns at the same tasks, solved by both.

Tasks of the scenario's grid and patterns that its search would try are drawn at random and solved as the search does
it, from the nominal glide, until there are enough with a motion and enough given up. Then IPOPT solves the same,
without help from these results.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import child
from benchmarks.document import document
from benchmarks.rows import Row, RowStore
from benchmarks.search.search import patterns
from benchmarks.search.tasks import task_key, task_of, task_values
from gaitflow.config.scenario import Scenario
from gaitflow.core.check import FEASIBLE, worst
from gaitflow.core.gaits import Pattern
from gaitflow.core.task import Task
from gaitflow.problem import transcribe
from gaitflow.search import starts
from gaitflow.search.attempts import best_of, until_feasible
from gaitflow.search.exhaustive import candidate_patterns
from gaitflow.search.screen import why_impossible
from gaitflow.solvers.fixed_gait import FixedGaitSolver
from gaitflow.solvers.ipopt import call_solver, make_ipopt
from gaitflow.solvers.options import CONVERGED, IPOPT

SOLVED, FAILED = 300, 100  # patterns of either kind that are wanted
DRAWS_PER_PATTERN = 10  # beyond which a scenario has not enough of one kind
BATCH = 20
TRIES = 100  # draws in a row that were drawn before, after which there is nothing new
SAME = 1e-4  # relative cost up to which two solves agree
ITERATIONS = 1000  # of IPOPT: a referee should not fail for want of them
SOLVE_LIMIT_S = 600.0  # wall time: the machine may be busy
NOTES = (
    f"Random tasks of the grid and random patterns, screened ones left out, until {SOLVED} were solved and {FAILED} "
    "given up, or too many of one kind were met: drawn tells how many of each. Both start from the nominal glide; ours "
    "goes on to random starts, and to IPOPT, where the search would.",
    f"solved: of those that we solved, IPOPT found a motion, too. Of these, cheaper, equal and dearer say how our cost "
    f"compares with IPOPT's: equal within {SAME:g} of it. cheaper_rel_max, dearer_rel_max: the largest differences, as "
    "shares of IPOPT's cost. missed_by_ipopt: we found a motion and IPOPT none.",
    "failed_but_feasible: we gave the pattern up, and IPOPT found a motion that our check confirms.",
    f"IPOPT may take {ITERATIONS} iterations. cpu_ratio_solved: CPU time of all IPOPT's solves of patterns that both "
    "solved, over that of ours; cpu_ratio_failed: of those that both gave up.",
)


class Referee:
    """Both methods on a scenario's problem; made to be called in a child process."""

    def __init__(self, scenario: Mapping[str, Any]) -> None:
        self._scenario = Scenario.from_data(scenario, "the bench's scenario")
        self._problem = transcribe(self._scenario)
        limit = self._scenario.strategy.solve_time_limit
        self._ours = FixedGaitSolver(self._problem, limit)
        self._ipopt = make_ipopt(self._problem.nlp, IPOPT | {"max_iter": ITERATIONS, "max_cpu_time": 10 * limit})

    def __call__(self, task: Mapping[str, float], pattern: str) -> dict[str, Any]:
        """What both made of a pattern at a task, `ours` and `ipopt`."""
        at, gait = task_of(self._scenario, task), Pattern.from_text(pattern)
        self._ours.method(gait)  # orders its matrix
        attempts = until_feasible(self._ours, gait, at, None, self._scenario.strategy.restarts)
        best = best_of(attempts)
        return {
            "ours": {
                "cost": best.cost if best else None,
                "method": best.method if best else None,
                "solver_status": (best or attempts[-1]).solver_status,
                "cpu_s": sum(attempt.cpu_s for attempt in attempts),
            },
            "ipopt": self._by_ipopt(gait, at),
        }

    def _by_ipopt(self, pattern: Pattern, task: Task) -> dict[str, Any]:
        bounds, layout = self._problem.bounds(pattern), self._problem.layout
        cpu = time.process_time()
        status, iterations, result = call_solver(
            self._ipopt,
            {
                "x0": starts.nominal(self._scenario.robot, layout, task),
                "p": task.parameters,
                "lbx": bounds.lower,
                "ubx": bounds.upper,
                "lbg": bounds.lower_rows,
                "ubg": bounds.upper_rows,
            },
        )
        cpu = time.process_time() - cpu
        motion = layout.unpack(result["x"], task.cycle_duration)
        feasible = status in CONVERGED and worst(self._scenario.as_data(), motion, task, pattern.text) <= FEASIBLE
        cost = float(result["f"][0]) * self._problem.cost_scale
        return {"cost": cost if feasible else None, "solver_status": status, "iterations": iterations, "cpu_s": cpu}


def run(scenario: Scenario, tasks: int | None = None, seed: int = 0, runs: Path = Path("runs")) -> Row:
    """The document: a row a pattern; what was solved before, kept below `runs`, is reused.

    `tasks` is how many solved patterns are wanted, and a third as many given up.
    """
    wanted = {True: SOLVED if tasks is None else tasks}
    wanted[False] = FAILED if tasks is None else -(-tasks * FAILED // SOLVED)
    searched = patterns(scenario)
    keys, rows = draws(searched, seed), list[Row]()
    store = RowStore("referee", searched, runs, [sys.modules[__name__]])
    with child.Child("benchmarks.search.referee:Referee", {"scenario": searched.as_data()}) as process:

        def measure(key: Row) -> Row:
            try:
                return dict(process.call(SOLVE_LIMIT_S, task=task_values(searched, key), pattern=key["pattern"]))
            except child.Lost as lost:
                nothing = {"cost": None, "method": None, "solver_status": str(lost), "cpu_s": lost.cpu_s}
                return {"ours": nothing, "ipopt": nothing}

        left = DRAWS_PER_PATTERN * sum(wanted.values())
        while left > 0 and any(wanted.values()):
            batch = list(islice(keys, BATCH))
            if not batch:
                break
            for row in store.rows(batch, measure):
                found = row["ours"]["cost"] is not None
                if wanted[found]:
                    wanted[found] -= 1
                    rows.append(row | {"verdict": verdict(row)})
            left -= BATCH
    return document("referee", scenario.name, rows, summarise(rows), NOTES)


def draws(scenario: Scenario, seed: int) -> Iterator[Row]:
    """Random tasks and patterns, as the fields of a row, until hardly any is new; none that a screen rules out."""
    rng = np.random.default_rng(seed)
    axes = {axis: each.values for axis, each in scenario.tasks.ranges.items()}
    seen: set[tuple[Task, Pattern]] = set()
    old = 0
    while old < TRIES:
        task = scenario.tasks.space.task({axis: float(rng.choice(values)) for axis, values in axes.items()})
        candidates = candidate_patterns(scenario, task)
        pattern = candidates[int(rng.integers(len(candidates)))]
        old = old + 1 if (task, pattern) in seen else 0
        if not old and why_impossible(scenario, pattern, task) is None:
            yield task_key(scenario, task) | {"pattern": pattern.text}
        seen.add((task, pattern))


def verdict(row: Mapping[str, Any]) -> str:
    """How our cost compares with IPOPT's, and what is said where one of them, or both, found no motion."""
    ours, theirs = row["ours"]["cost"], row["ipopt"]["cost"]
    if ours is None:
        return "infeasible" if theirs is None else "failed_but_feasible"
    if theirs is None:
        return "missed_by_ipopt"
    difference = ours / theirs - 1
    return "equal" if abs(difference) <= SAME else "cheaper" if difference < 0 else "dearer"


def summarise(rows: Sequence[Mapping[str, Any]]) -> Row:
    """How often they agree, by how much they differ at most, and what it took; see NOTES."""
    counts = Counter(row["verdict"] for row in rows)
    both = [row for row in rows if row["verdict"] in ("cheaper", "equal", "dearer")]
    neither = [row for row in rows if row["verdict"] == "infeasible"]
    differences = [row["ours"]["cost"] / row["ipopt"]["cost"] - 1 for row in both]
    failed = len(neither) + counts["failed_but_feasible"]
    return {
        "drawn": {"solved": len(rows) - failed, "failed": failed},
        "solved": len(both),
        **{key: counts[key] for key in ("cheaper", "equal", "dearer", "failed_but_feasible", "missed_by_ipopt")},
        "cheaper_rel_max": -min(differences, default=0.0),
        "dearer_rel_max": max(differences, default=0.0),
        "by_interior_point": sum(row["ours"]["method"] == "interior_point" for row in rows),
        "cpu_ratio_solved": _ratio(both),
        "cpu_ratio_failed": _ratio(neither),
        "cpu_s_median": statistics.median(row["ours"]["cpu_s"] for row in both) if both else None,
    }


def _ratio(rows: Sequence[Mapping[str, Any]]) -> float | None:
    ours = sum(row["ours"]["cpu_s"] for row in rows)
    return sum(row["ipopt"]["cpu_s"] for row in rows) / ours if ours else None
