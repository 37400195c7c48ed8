"""How far a run is, read from its folder: while it runs, after it, from another machine, and without Dask."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from gaitflow.dataset.attempts import Attempt
from gaitflow.dataset.store import UnitStore
from gaitflow.dataset.units import plan_units
from gaitflow.execute.journal import read_journal
from gaitflow.scenario import Scenario

LATEST_ERRORS = 5


@dataclass(frozen=True)
class RunStatus:
    """Counts of units (`units` = `solved` + `failed` + `left`), CPU hours spent and, from them, still to spend.

    `cpu_hours_left` is None while nothing is solved. `quarantined` parts were damaged. `errors` are the latest
    attempts that the solver did not survive, newest first.
    """

    scenario: str
    units: int
    solved: int
    failed: int
    left: int
    quarantined: int
    cpu_hours_spent: float
    cpu_hours_left: float | None
    errors: tuple[Attempt, ...]

    def as_data(self) -> dict[str, Any]:
        """Plain JSON data."""
        return asdict(self)


def run_status(scenario: Scenario, store: UnitStore) -> RunStatus:
    """The state of a scenario's run as its store tells it; nothing is written."""
    planned = {unit.digest for unit in plan_units(scenario)}
    stored = store.solved() & planned
    failed = store.attempts.given_up() & stored
    left = len(planned) - len(stored)
    spent = {e.unit: e.cpu_s for e in read_journal(store.folder / "journal") if e.event == "stored" and e.kept}
    hours = sum(cpu for unit, cpu in spent.items() if unit in planned) / 3600
    known = len(spent.keys() & planned)
    return RunStatus(
        scenario=scenario.name,
        units=len(planned),
        solved=len(stored) - len(failed),
        failed=len(failed),
        left=left,
        quarantined=len(list((store.folder / "quarantine").glob("*.parquet"))),
        cpu_hours_spent=hours,
        cpu_hours_left=hours / known * left if known else (0.0 if not left else None),
        errors=tuple(store.attempts.latest(LATEST_ERRORS)),
    )
