"""What one pattern costs to solve, and how that and the number of patterns grow with legs, phases and knots."""

from __future__ import annotations

import statistics
import sys
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from benchmarks import child
from benchmarks.document import document
from benchmarks.rows import Row, RowStore
from benchmarks.search.pattern_count import count_patterns
from benchmarks.search.tasks import middle
from gaitflow.config.scenario import Scenario, Transcription
from gaitflow.core.gaits import Pattern
from gaitflow.core.layout import Layout
from gaitflow.problem import transcribe
from gaitflow.search import starts
from gaitflow.solvers.fixed_gait import FixedGaitSolver, Start

SCENARIOS = ("half-cheetah-flat-vibration", "anymal-flat-vibration")
SIZES = tuple(product((4, 6, 8), (5, 10, 20)))  # phases, knots per phase
NOTES = (
    "A size is a scenario's problem with other phases and knots a phase, its shortest phase cut as there are more "
    "of them; the task is the middle of the grid. variables: of the program with a fixed gait. patterns: with one "
    "stance a leg, up to where the cycle is cut and to the symmetries of robot, ground and task; counted by "
    "Burnside's lemma. patterns_any_stances: without that restriction.",
    "cpu_s_median, cpu_s_p90, iterations_median: of one cold solve, from the nominal glide, of random patterns in "
    "which every leg stands once and swings once, feasible or not: by the interior point, and where that comes to no "
    "verdict by IPOPT. feasible: the share that our check confirms. "
    "cpu_s_per_solved: all CPU time over the feasible ones. exhaustive_cpu_h: patterns times the mean CPU time, [h].",
    "cpu_s_per_labelled_task: of the scenario's own map, at the size at which it was made, from `gaitflow bench map`; "
    "null elsewhere.",
)


class SizedSolves:
    """Cold solves of random patterns at the middle task; made to be called in a child process."""

    def __init__(self, scenario: Mapping[str, Any]) -> None:
        sized = Scenario.from_data(scenario, "the bench's scenario")
        self._task = middle(sized)
        self._problem = transcribe(sized)
        self._solver = FixedGaitSolver(self._problem, sized.strategy.solve_time_limit)

    def __call__(self, pattern: str) -> dict[str, Any]:
        """One solve from the nominal start, building excluded."""
        start = Start("nominal", starts.nominal(self._problem.scenario.robot, self._problem.layout, self._task))
        done = self._solver.solve(Pattern.from_text(pattern), self._task, start)
        return {
            "feasible": done.feasible,
            "method": done.method,
            "solver_status": done.solver_status,
            "iterations": done.iterations,
            "cpu_s": done.cpu_s,
        }


def run(
    scenarios: Sequence[Scenario],
    sizes: Sequence[tuple[int, int]] = SIZES,
    solves: int = 10,
    seed: int = 0,
    runs: Path = Path("runs"),
    map_cpu_s: Mapping[str, float] = MappingProxyType({}),
) -> Row:
    """The document: a row a solve, in the summary an object a size; rows kept below `runs` are reused.

    `map_cpu_s` is the CPU time [s] per labelled task of the scenarios' maps, by name.
    """
    rows: list[Row] = []
    summary: Row = {}
    for scenario, (phases, knots) in product(scenarios, sizes):
        sized = resized(scenario, phases, knots)
        legs = len(sized.robot.legs)
        measured = _solve(sized, random_patterns(legs, phases, solves, seed), runs)
        rows += [{"legs": legs, "phases": phases, "knots_per_phase": knots} | row for row in measured]
        in_map = map_cpu_s.get(scenario.name) if sized.transcription == scenario.transcription else None
        summary[f"{legs} legs, {phases} phases, {knots} knots"] = _size(sized, measured) | {
            "cpu_s_per_labelled_task": in_map
        }
    return document("scaling", None, rows, summary, NOTES)


def resized(scenario: Scenario, phases: int, knots_per_phase: int) -> Scenario:
    """The scenario with other phases and knots; all shortest phases together take the same part of the cycle."""
    given = scenario.transcription
    shortest = given.min_phase_fraction * given.phases / phases
    changes = {"phases": phases, "knots_per_phase": knots_per_phase, "min_phase_fraction": round(shortest, 9)}
    return scenario.model_copy(update={"transcription": Transcription(**(given.model_dump() | changes))})


def random_patterns(legs: int, phases: int, count: int, seed: int) -> list[str]:
    """Patterns in which every leg has one stance and one swing a cycle, each equally likely: they can all move."""
    rng = np.random.default_rng([seed, legs, phases])

    def row() -> str:
        stance, cut = int(rng.integers(1, phases)), int(rng.integers(phases))
        text = "1" * stance + "0" * (phases - stance)
        return text[cut:] + text[:cut]

    return ["/".join(row() for _ in range(legs)) for _ in range(count)]


def _solve(sized: Scenario, patterns: Sequence[str], runs: Path) -> list[Row]:
    limit = 10 * sized.strategy.solve_time_limit  # wall time: the machine may be busy
    with child.Child("benchmarks.search.scaling:SizedSolves", {"scenario": sized.as_data()}) as process:

        def measure(key: Row) -> Row:
            try:
                return dict(process.call(limit, **key))
            except child.Lost as lost:
                nothing = {"feasible": False, "method": None, "iterations": 0}
                return {**nothing, "solver_status": str(lost), "cpu_s": lost.cpu_s}

        store = RowStore("scaling", sized, runs, [sys.modules[__name__]])
        return store.rows([{"pattern": pattern} for pattern in patterns], measure)


def _size(sized: Scenario, rows: Sequence[Row]) -> Row:
    legs, phases, symmetry = len(sized.robot.legs), sized.transcription.phases, sized.symmetry(middle(sized))
    times = [row["cpu_s"] for row in rows]
    feasible = sum(row["feasible"] for row in rows)
    patterns = count_patterns(legs, phases, 1, symmetry)
    return {
        "variables": Layout.of(sized.as_data()).nw,
        "patterns": patterns,
        "patterns_any_stances": count_patterns(legs, phases, None, symmetry),
        "solves": len(rows),
        "feasible": feasible / len(rows),
        "iterations_median": statistics.median(row["iterations"] for row in rows),
        "cpu_s_median": statistics.median(times),
        "cpu_s_p90": float(np.quantile(times, 0.9)),
        "cpu_s_per_solved": sum(times) / feasible if feasible else None,
        "exhaustive_cpu_h": patterns * statistics.fmean(times) / 3600,
    }
