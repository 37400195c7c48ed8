"""What a plan solves while a map is in the making: from the starts that a published map has, in several processes."""

from __future__ import annotations

from collections.abc import Sequence

from gaitflow.atlas.node import NodeSolver, Place
from gaitflow.runtime.starts import Start

Try = tuple[int, Place, Start]  # a pattern's number, where it is to be solved, and from which start


class PlanSolver(NodeSolver):
    """Solves nodes, and what plans ask for."""

    def costs_from(self, tries: Sequence[Try], limit: int) -> list[float | None]:
        """`cost_from` for each try."""
        if self._each is None:
            return [self.cost_from(*each, limit) for each in tries]
        self.solves += len(tries)
        return self._each("cost_from", [(self.patterns[sheet], (*where, limit)) for sheet, *where in tries])

    def cost_from(self, sheet: int, place: Place, start: Start, limit: int) -> float | None:
        """The problem's cost of the motion that a plan's start leads to; None where none passes the check."""
        self.solves += 1
        method, task = self.methods[sheet], self.parameters(place)
        found = method.follow(task, start.point, start.unit, start.barrier, limit, start.careful)
        return found.cost if self._is_solution(sheet, place, found) else None
