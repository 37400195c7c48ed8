"""How many solves units take: predicted from a scenario, then corrected by the units that are done."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from gaitflow.store.units import Unit

AGAIN = 1.25  # solves a pattern: most need one, the best few are solved again
OF_BUDGET = 0.4  # a guided search rarely spends its budget; published maps took 92 and 186 of 300 solves a task


def solves_per_task(unit: Unit) -> float:
    """About how many solves a task of this unit takes, by its strategy and the patterns that a screen leaves."""
    from gaitflow.search.bound import ruled_out
    from gaitflow.search.exhaustive import candidate_patterns

    scenario, task = unit.scenario, unit.tasks[len(unit.tasks) // 2]
    strategy = scenario.strategy
    if strategy.name == "bonmin":
        return float(len(unit.seeds or (0,)))
    if strategy.name == "guided":
        return OF_BUDGET * strategy.budget
    cost = math.inf if strategy.incumbent is None else strategy.incumbent
    left = [one for one in candidate_patterns(scenario, task) if ruled_out(scenario, one, task, cost) is None]
    return AGAIN * len(left)


class ExpectedSolves:
    """Corrects what was foretold by what finished units took; until one is finished that stands."""

    def __init__(self, per_task: float) -> None:
        self._solves, self._tasks = per_task, 1.0
        self.solved = 0  # in finished units

    @classmethod
    def of_plan(cls, units: Sequence[Unit]) -> ExpectedSolves:
        """What the first, the middle and the last unit let expect."""
        chosen = {units[0], units[len(units) // 2], units[-1]} if units else set[Unit]()
        return cls(sum(map(solves_per_task, chosen)) / max(1, len(chosen)))

    def finished(self, unit: Unit, solves: int) -> None:
        """A unit took so many solves."""
        self.solved += solves
        self._solves += solves
        self._tasks += len(unit.tasks)

    def of(self, unit: Unit) -> float:
        """Solves that a unit will take."""
        return self._solves / self._tasks * len(unit.tasks)

    def left(self, units: Mapping[str, Unit], in_work: Mapping[str, int]) -> float:
        """Solves that are left in units by their digests, of which some have had solves already."""
        return sum(max(self.of(unit) - in_work.get(digest, 0), 0.0) for digest, unit in units.items())
