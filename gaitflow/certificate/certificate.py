"""A map's certificate: at most how many of its domain's tasks get a pick that is too dear, or one without a motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from gaitflow.certificate.bound import CONFIDENCE, chances_of, upper_bound
from gaitflow.certificate.judge import DEARER, Verdict


@dataclass(frozen=True)
class Certificate:
    """What holds for a map with the confidence `confidence`, by the asking number `asking`.

    At most the share `dearer_bound` of its domain's tasks get a pick more than `tolerance` dearer than the best that
    the scenario's search finds, and at most `infeasible_bound` one without a motion. searched: random tasks that were
    searched, none of which had a part in making the map, of which `dearer` picks failed. planned: those and further
    ones whose picks were planned only, of which `infeasible` have no motion. cheaper: picks that cost less than what
    the search found. worst_excess: the largest excess of a pick with a motion.
    """

    searched: int
    dearer: int
    dearer_bound: float
    planned: int
    infeasible: int
    infeasible_bound: float
    cheaper: int
    worst_excess: float
    asking: int
    seed: int
    tolerance: float = DEARER
    confidence: float = CONFIDENCE

    def __str__(self) -> str:
        return (
            f"with {self.confidence:.0%} confidence at most {self.dearer_bound:.2%} of the domain's tasks get a pick "
            f"more than {self.tolerance:.0%} dearer than the search's best, at most {self.infeasible_bound:.2%} one "
            f"without a motion ({self.dearer} of {self.searched} searched, {self.infeasible} of {self.planned} planned)"
        )

    def as_data(self) -> dict[str, Any]:
        """Plain JSON data."""
        return asdict(self)


def certify(verdicts: Sequence[Verdict], further: Sequence[bool], asking: int, seed: int) -> Certificate:
    """The certificate of searched picks, and of `further` ones, of which is only known whether they have a motion."""
    chance_dearer, chance_infeasible = chances_of(asking)
    dearer = sum(verdict.dearer for verdict in verdicts)
    infeasible = sum(verdict.infeasible for verdict in verdicts) + sum(not feasible for feasible in further)
    planned = len(verdicts) + len(further)
    return Certificate(
        searched=len(verdicts),
        dearer=dearer,
        dearer_bound=upper_bound(dearer, len(verdicts), chance_dearer),
        planned=planned,
        infeasible=infeasible,
        infeasible_bound=upper_bound(infeasible, planned, chance_infeasible),
        cheaper=sum(verdict.excess < -1e-6 for verdict in verdicts),
        worst_excess=max((one.excess for one in verdicts if not one.infeasible), default=0.0),
        asking=asking,
        seed=seed,
    )
