"""How many plans of a published map may be wrong: `gaitflow certify`, with every task that it was judged at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from benchmarks.document import document
from benchmarks.rows import Row
from gaitflow.certificate.certificate import Certificate
from gaitflow.certificate.judge import DEARER, Verdict
from gaitflow.pipeline.certify import certify_map
from gaitflow.pipeline.workspace import Workspace
from gaitflow.runtime import GaitMap

WORKERS = 2
NOTES = (
    "A row for each of the random tasks of the map's domain that were searched, by the scenario's own strategy, from "
    "nothing that is known. gait: that of the plan. best: the cheapest that the search found. excess: what the plan "
    "costs over that, less 1; negative where the plan is cheaper than all that was searched; null without a plan.",
    f"dearer: plans with an excess above {DEARER:.0%} or without a motion. dearer_bound: the share of the domain's "
    "tasks with such a plan, at most, with 95 % confidence (Clopper and Pearson). infeasible, infeasible_bound: of "
    "these and of further tasks, `planned` in all, those without a plan. The two bounds hold together. "
    "selected_dearer, selected_bound: of the gait that `select` names before anything is solved; that bound holds by "
    "itself.",
    "The tasks are fixed by `seed` and had no part in making the map. The bounds are of this document alone: who asks "
    "with several seeds and shows the best of them has another confidence.",
)


def run(workspace: Workspace, artifact: Path, tasks: int | None, seed: int) -> Row:
    """The document: a row a searched task. What was searched is kept in runs/certify-NAME-VERSION.

    `tasks` None searches as many as bound the dearer plans by 2 % when none fails. Raises as `certify_map`.
    """
    certificate, verdicts, gait_map = certify_map(workspace, artifact, WORKERS, tasks, seed)
    rows = [row(verdict, gait_map) for verdict in verdicts]
    return document("certify", gait_map.manifest.name, rows, summarise(certificate, verdicts, gait_map), NOTES)


def row(verdict: Verdict, gait_map: GaitMap) -> Row:
    """A judged plan: the task's values by axis, names of gaits, the excess."""
    names = {gait.key: gait.name for gait in gait_map.gaits}
    return {
        **{axis: verdict.task[axis] for axis in gait_map.axes},
        "gait": names.get(verdict.pick, verdict.pick),
        "best": names.get(verdict.best, verdict.best),
        "excess": verdict.excess,
    }


def summarise(certificate: Certificate, verdicts: Sequence[Verdict], gait_map: GaitMap) -> Row:
    """The certificate, the map's version, and at how many tasks the plan's gait is the search's best."""
    same = sum(verdict.pick == verdict.best for verdict in verdicts)
    return {"version": str(gait_map.manifest.version), "same_gait": same, **asdict(certificate)}
