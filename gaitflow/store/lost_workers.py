"""Units that take their worker with them: when all processes of a job are killed at once, nobody records an attempt.

Slurm does so to a job that used more than its memory, and a machine that runs out of it may. The journal knows these
solves: they were begun, and nothing was heard of the solver since. A worker that is asked to end, by preemption or
scancel, writes down the end of its solve, as it does for a solver that died. So the limit is far from what nodes that
fail do to one unit, and from the few other runs on the same store that may be solving it just now.
"""

from __future__ import annotations

from collections.abc import Iterable

from gaitflow.store.journal import unended, write_off
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit

MAX_LOST_WORKERS = 8  # of one unit


def give_up_after_lost_workers(store: UnitStore, units: Iterable[Unit]) -> None:
    """Allow no further attempt at those of `units` that MAX_LOST_WORKERS workers began and were never heard of again.

    What led to it is written off: without its attempts a unit can be tried again. Raises OSError.
    """
    journal = store.folder / "journal"
    found = unended(journal)
    for unit in units:
        solvers = found.get(unit.digest, ())
        if len(solvers) >= MAX_LOST_WORKERS:
            store.attempts.record(unit, f"its worker was lost {len(solvers)} times: out of memory?", last=True)
            write_off(journal, unit.digest, solvers)
