"""How far a transcription and its mesh are from the truth: error of the best cost, wrong labels and CPU time.

Some tasks of a scenario, some gaits of each: those that come out cheapest under Euler's rule, the paper's, and under
the scenario's own. Each gait is solved from the same nominal start on every transcription and mesh, and on a fine
reference. A label is wrong where the gait that a mesh takes for the cheapest is dearer on the reference by more.
"""

from __future__ import annotations

import statistics
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path

from benchmarks import child
from benchmarks.document import document
from benchmarks.rows import Row, RowStore
from benchmarks.search import mesh_solves
from benchmarks.search import search as searching
from benchmarks.search.search import ours, search
from benchmarks.search.tasks import spread_tasks, task_key, task_of, task_values
from gaitflow.config.scenario import Scenario, Transcription
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.task import Task

INTEGRATORS = ("rk4", "midpoint", "hermite_simpson", "momentum")
KNOTS = (5, 7, 10, 14, 20)  # a phase
REFERENCE_KNOTS = 30
LEADERS = 4  # gaits of a search that are looked at
WRONG = 0.01  # relative cost from which a label counts as wrong
SEARCH_LIMIT_S, SOLVE_LIMIT_S = 3600.0, 600.0  # wall time: the machine may be busy


@dataclass(frozen=True, order=True)
class Rule:
    """A way to turn a motion into a program, whatever its mesh: the settings of `Transcription` that say so."""

    integrator: str
    forces: str
    grading: float

    def on(self, scenario: Scenario, knots: int) -> Scenario:
        """The scenario transcribed by this rule with so many knots a phase."""
        settings = scenario.transcription.model_dump() | asdict(self) | {"knots_per_phase": knots}
        return scenario.model_copy(update={"transcription": Transcription(**settings)})


EULER = Rule("euler", "held", 0.0)
NOTES = (
    "rule: integrator, forces held or linear over a step, grading of the knots in a phase (0: even). knots: a phase. "
    "A row is over all tasks and gaits; each solve starts from the nominal glide, building excluded.",
    "best_cost_error: |cheapest cost - cheapest cost of the reference| over the latter, a task each, median and worst. "
    f"The reference: momentum, linear forces, graded knots, {REFERENCE_KNOTS} a phase; of a gait the cheaper of two "
    "solves, from the nominal glide and from the motion on the scenario's own mesh.",
    "compared: tasks where rule and reference have a motion. wrong_labels: of these, where the reference cost of the "
    f"rule's cheapest gait is more than {WRONG:.0%} above that of the best; wrong_worst: the largest such excess. "
    "failed: solves without a motion where the reference has one.",
    "cpu_s_median, iterations_median: of one solve that found a motion. cpu_ratio_to_euler10: its CPU time over that "
    "of Euler's rule with 10 knots for the same gait and task, the median over those where both found a motion; "
    "cpu_ratio_total: the sums instead, in which the few solves that IPOPT had to take over weigh most (by_ipopt).",
    f"Gaits of a task: the cheapest {LEADERS} of a search under Euler's rule with the scenario's knots, and as many of "
    "one under its own. The summary is of the scenario's own rule, or of the reference's with its knots where that is "
    "Euler's.",
)


def rules(scenario: Scenario) -> tuple[Rule, ...]:
    """Euler's, and every integrator with what the others have and with what makes it best; held forces beside linear.

    Graded as the scenario is, or by the cosine where it is not.
    """
    graded = scenario.transcription.grading or 1.0
    return (
        EULER,
        *(Rule(integrator, "held", 0.0) for integrator in INTEGRATORS),
        Rule("momentum", "held", graded),
        Rule("momentum", "linear", 0.0),
        *(Rule(integrator, "linear", graded) for integrator in INTEGRATORS),
    )


def run(
    scenario: Scenario,
    tasks: int = 6,
    seed: int = 0,
    runs: Path = Path("runs"),
    knots: Sequence[int] = KNOTS,
    chosen_rules: Sequence[Rule] | None = None,
) -> Row:
    """The document: a row a rule and mesh; solves measured before, kept below `runs`, are reused.

    Raises ValueError when the grid has fewer tasks.
    """
    places = spread_tasks(scenario, tasks, seed)
    gaits = _gaits(scenario, places, runs)
    own = own_rule(scenario)
    fine = _solved(scenario, reference_rule(scenario), REFERENCE_KNOTS, gaits, runs, start_from=own)
    measured = {
        (rule, size): _solved(scenario, rule, size, gaits, runs)
        for rule, size in product(chosen_rules or rules(scenario), knots)
    }
    yardstick = measured[EULER, 10] if (EULER, 10) in measured else _solved(scenario, EULER, 10, gaits, runs)
    rows = [
        asdict(rule) | {"knots": size} | judge(scenario, solves, fine, yardstick)
        for (rule, size), solves in measured.items()
    ]
    return document("mesh", scenario.name, rows, summarise(scenario, rows), NOTES)


def reference_rule(scenario: Scenario) -> Rule:
    """Exact in momentum, linear forces, graded knots."""
    return Rule("momentum", "linear", scenario.transcription.grading or 1.0)


def own_rule(scenario: Scenario) -> Rule:
    """The scenario's, or the reference's where that is Euler's."""
    given = scenario.transcription
    if given.integrator == "euler":
        return reference_rule(scenario)
    return Rule(given.integrator, given.forces, given.grading)


def judge(scenario: Scenario, solves: Sequence[Row], fine: Sequence[Row], euler: Sequence[Row]) -> Row:
    """One rule on one mesh beside the reference and Euler's rule with 10 knots; see NOTES for what the numbers mean."""
    truth, found = _by_task(scenario, fine), _by_task(scenario, solves)
    errors, excesses = [], []
    for task, costs in found.items():
        if not costs or not truth[task]:
            continue
        pick, best = min(costs, key=lambda pattern: (costs[pattern], pattern)), min(truth[task].values())
        errors.append(abs(costs[pick] - best) / best)
        if pick in truth[task]:
            excesses.append(truth[task][pick] / best - 1)
    wrong = [excess for excess in excesses if excess > WRONG]
    known = {(task, pattern) for task, costs in truth.items() for pattern in costs}
    motions = [row for row in solves if row["cost"] is not None]
    pairs = [(row, other) for row, other in zip(solves, euler, strict=True) if row["feasible"] and other["feasible"]]
    ratios = [row["cpu_s"] / other["cpu_s"] for row, other in pairs]
    spent = sum(other["cpu_s"] for _, other in pairs)
    return {
        "compared": len(errors),
        "best_cost_error_median": statistics.median(errors) if errors else None,
        "best_cost_error_worst": max(errors, default=None),
        "wrong_labels": len(wrong),
        "wrong_worst": max(wrong, default=0.0),
        "failed": sum((task_of(scenario, row), row["pattern"]) in known and row["cost"] is None for row in solves),
        "solves": len(solves),
        "iterations_median": statistics.median(row["iterations"] for row in motions) if motions else None,
        "cpu_s_median": statistics.median(row["cpu_s"] for row in motions) if motions else None,
        "by_ipopt": sum(row["method"] == "ipopt" for row in motions),
        "cpu_ratio_to_euler10": statistics.median(ratios) if ratios else None,
        "cpu_ratio_total": sum(row["cpu_s"] for row, _ in pairs) / spent if spent else None,
    }


def summarise(scenario: Scenario, rows: Sequence[Row]) -> Row:
    """The row of the scenario's own rule and mesh; nothing when it was not among those measured."""
    own = asdict(own_rule(scenario)) | {"knots": scenario.transcription.knots_per_phase}
    found = next((row for row in rows if own.items() <= row.items()), None)
    return own | {
        key: None if found is None else found[key]
        for key in (
            "compared", "best_cost_error_median", "best_cost_error_worst", "wrong_labels", "wrong_worst", "failed",
            "cpu_ratio_to_euler10", "cpu_ratio_total",
        )
    }  # fmt: skip


def _gaits(scenario: Scenario, places: Sequence[Task], runs: Path) -> list[Row]:
    """A task's fields and a pattern each: the cheapest gaits under Euler's rule and under the scenario's own."""
    found: dict[Task, dict[str, None]] = {place: {} for place in places}
    for rule in dict.fromkeys((EULER, own_rule(scenario))):
        searched = ours(rule.on(scenario, scenario.transcription.knots_per_phase))
        store = RowStore("mesh", searched, runs, [searching])
        with child.Child("benchmarks.search.search:Search", {"scenario": searched.as_data()}) as process:
            keys = [task_key(scenario, place) for place in places]
            rows = store.rows(keys, lambda key: search(process, task_values(scenario, key), None, SEARCH_LIMIT_S))
        for place, row in zip(places, rows, strict=True):
            found[place] |= dict.fromkeys(_leaders(searched, place, row["costs"]))
    return [task_key(scenario, place) | {"pattern": pattern} for place in places for pattern in found[place]]


def _leaders(scenario: Scenario, task: Task, costs: Mapping[str, float]) -> Iterator[str]:
    """The cheapest pattern of each of the LEADERS cheapest gaits."""
    seen: set[Pattern] = set()
    for text in sorted(costs, key=lambda text: (costs[text], text)):
        gait = gait_of(Pattern.from_text(text), scenario.symmetry(task))
        if gait not in seen and len(seen) < LEADERS:
            seen.add(gait)
            yield text


def _solved(
    scenario: Scenario, rule: Rule, knots: int, gaits: Sequence[Row], runs: Path, start_from: Rule | None = None
) -> list[Row]:
    """A row a task and gait: its motion by a rule on a mesh, from the nominal start.

    With `start_from` the cheaper of that and of a second solve, from the motion by that rule on the scenario's mesh.
    """
    coarse = None if start_from is None else start_from.on(scenario, scenario.transcription.knots_per_phase).as_data()
    setup = {"scenario": rule.on(scenario, knots).as_data(), "coarse": coarse}
    about = {"rule": asdict(rule), "knots": knots, "coarse": coarse}
    store = RowStore("mesh", scenario, runs, [mesh_solves], about)
    with child.Child("benchmarks.search.mesh_solves:MeshSolves", setup) as process:

        def measure(key: Row) -> Row:
            try:
                return dict(process.call(SOLVE_LIMIT_S, task=task_values(scenario, key), pattern=key["pattern"]))
            except child.Lost as lost:
                return {"feasible": False, "cost": None, "iterations": 0, "cpu_s": lost.cpu_s, "method": None}

        return store.rows(gaits, measure)


def _by_task(scenario: Scenario, solves: Sequence[Row]) -> dict[Task, dict[str, float]]:
    """Costs of the motions found, by task and pattern."""
    found: dict[Task, dict[str, float]] = defaultdict(dict)
    for row in solves:
        costs = found[task_of(scenario, row)]
        if row["cost"] is not None:
            costs[row["pattern"]] = row["cost"]
    return found
