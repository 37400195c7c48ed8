"""A map's certificate: at most how many of its domain's tasks get a pick that is too dear, or one without a motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from gaitflow.certificate.bound import CONFIDENCE, chance_of, chances_of, upper_bound
from gaitflow.certificate.judge import DEARER, Verdict


@dataclass(frozen=True)
class Certificate:
    """What holds for a map with the confidence `confidence`, by the asking number `asking`.

    At most the share `dearer_bound` of its domain's tasks get a plan more than `tolerance` dearer than the best that
    the scenario's search finds, and at most `infeasible_bound` none. searched: random tasks that were searched, none of
    which had a part in making the map, of which `dearer` plans failed. planned: those and further ones that were
    planned only, of which `infeasible` have no plan. cheaper: plans that cost less than what the search found.
    worst_excess: the largest excess of a plan.

    selected_dearer: how many of the searched tasks get a gait by `select`, before anything is solved, whose own motion
    is more than `tolerance` dearer or not there. selected_bound: that bound for these, which holds with the same
    confidence by itself. Certificates from before plans were judged have neither; all that they say is of selections.

    learning: the digest of what trained the classifier that the plans asked. None in documents of published maps, and
    in certificates from before it was kept.
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
    selected_dearer: int | None = None
    selected_bound: float | None = None
    learning: str | None = None
    tolerance: float = DEARER
    confidence: float = CONFIDENCE

    def __str__(self) -> str:
        return (
            f"with {self.confidence:.0%} confidence at most {self.dearer_bound:.2%} of the domain's tasks get a plan "
            f"more than {self.tolerance:.0%} dearer than the search's best, at most {self.infeasible_bound:.2%} none "
            f"({self.dearer} of {self.searched} searched, {self.infeasible} of {self.planned} planned)"
        )

    def as_data(self) -> dict[str, Any]:
        """Plain JSON data, without `learning` where there is none."""
        return {key: value for key, value in asdict(self).items() if key != "learning" or value is not None}


def certify(
    plans: Sequence[Verdict],
    selections: Sequence[Verdict],
    further: Sequence[bool],
    asking: int,
    seed: int,
    learning: str | None = None,
) -> Certificate:
    """The certificate of plans at searched tasks, and of `further` ones, of which is only known whether there is one.

    `selections` are verdicts on the gaits that the map names at the searched tasks.
    """
    chance_dearer, chance_infeasible = chances_of(asking)
    dearer, selected = (sum(verdict.dearer for verdict in verdicts) for verdicts in (plans, selections))
    infeasible = sum(verdict.infeasible for verdict in plans) + sum(not feasible for feasible in further)
    planned = len(plans) + len(further)
    return Certificate(
        searched=len(plans),
        dearer=dearer,
        dearer_bound=upper_bound(dearer, len(plans), chance_dearer),
        planned=planned,
        infeasible=infeasible,
        infeasible_bound=upper_bound(infeasible, planned, chance_infeasible),
        cheaper=sum(verdict.excess < -1e-6 for verdict in plans),
        worst_excess=max((one.excess for one in plans if not one.infeasible), default=0.0),
        asking=asking,
        seed=seed,
        selected_dearer=selected,
        selected_bound=upper_bound(selected, len(selections), chance_of(asking)),
        learning=learning,
    )
