"""Which other gaits a plan tries once its first one is solved: those that may cost less, and those that are likely."""

from __future__ import annotations

from collections.abc import Mapping

from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.attempt import Effort

LEAST_SAVING = 1e-3  # relative cost that a rival must promise, and come, to save
GREAT_SAVING = 0.5  # relative cost for which it is tried harder
# Up to NEAR_AXES axes: where the first motion costs more than SURPRISE times what it might have at the least, it is
# across a cliff from the nodes around, and other gaits are off as well. Those that may cost SURPRISED times as much at
# the least are tried there.
SURPRISE, SURPRISED = 4.0, 1.25
# A gait that is so probably the best is tried whatever it may cost: where nodes are far apart predictions mislead.
LIKELY_FEW, LIKELY, LIKELY_WIDE = 0.5, 0.2, 0.02  # up to FEW_AXES axes, up to NEAR_AXES, and over more
# Over more than FEW_AXES axes one that hardly is the best is tried only if it comes first. Over slopes that spares half
# of all tries.
UNLIKELY, FEW_AXES = 3e-4, 2
EVEN = 0.5  # probability from which on a likely gait is tried as hard as the first one


def likely(atlas: Atlas, chances: Mapping[int, float]) -> set[int]:
    """The gaits, by their numbers, that are tried whatever they are predicted to cost."""
    least = LIKELY_WIDE if atlas.is_wide else LIKELY_FEW if _is_over_few_axes(atlas) else LIKELY
    return {gait for gait, chance in chances.items() if chance >= least}


def unlikely(atlas: Atlas, chances: Mapping[int, float]) -> set[int]:
    """The gaits, by their numbers, that are tried only if they come first; none over few axes."""
    return {gait for gait, chance in chances.items() if chance < UNLIKELY and not _is_over_few_axes(atlas)}


def tried_below(atlas: Atlas, least: float, cost: float) -> float:
    """The share of the least cost so far below which a gait may cost for being tried.

    `least` is what the first gait might have cost at the least, and `cost` what it came to.
    """
    return SURPRISED if not atlas.is_wide and cost > SURPRISE * least else 1 - LEAST_SAVING


def effort_for(least: float, cost: float, chance: float = 0.0) -> Effort:
    """How hard a gait is tried that may cost `least`, when the cheapest so far costs `cost`.

    `chance` is the probability that it is the best, of one that is tried for it.
    """
    if chance >= EVEN:
        return Effort.FIRST
    return Effort.PROMISING if least < cost * (1 - GREAT_SAVING) else Effort.RIVAL


def _is_over_few_axes(atlas: Atlas) -> bool:
    return len(atlas.axes) <= FEW_AXES
