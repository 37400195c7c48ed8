"""What planning from a map should reach, in the plane and in space, beside what was found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal


@dataclass(frozen=True)
class Target:
    """A number of the summary `online` writes, and the limit it should keep to: at least or at most."""

    number: str
    sense: Literal["at_least", "at_most"]
    limit: float

    def met(self, found: float | None) -> bool:
        """Whether a number keeps to the limit; none never does."""
        if found is None:
            return False
        return found >= self.limit if self.sense == "at_least" else found <= self.limit


def targets(dimension: int) -> tuple[Target, ...]:
    """Those of a robot in the plane (2) or in space (3); plan_ms in milliseconds, select_us in microseconds."""
    plane = dimension == 2
    return (
        Target("tasks", "at_least", 1000 if plane else 500),
        Target("feasible_rate", "at_least", 1.0),
        Target("consistent_tasks", "at_least", 60),
        Target("consistent_rate", "at_least", 0.99 if plane else 0.97),
        Target("fast_rate", "at_least", 0.98 if plane else 0.95),
        Target("plan_ms_p50", "at_most", 5.0 if plane else 25.0),
        Target("plan_ms_p99", "at_most", 15.0 if plane else 60.0),
        Target("speedup_vs_paper_median", "at_least", 100.0),
        Target("select_us_p50", "at_most", 30.0),
    )


def against(summary: Mapping[str, Any], dimension: int) -> dict[str, dict[str, Any]]:
    """Each target by its number: the limit, what the summary has, and whether that meets it."""
    return {
        target.number: {
            target.sense: target.limit,
            "found": summary[target.number],
            "meets": target.met(summary[target.number]),
        }
        for target in targets(dimension)
    }
