"""How alike the motions of a gait's region are: sections IV.B and IV.C on Fig. 6 and 10."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gaitflow.report.measures import Outcome, counted_share, verdict_of
from gaitflow.report.state_space import planes
from gaitflow.report.winners import most_common_pattern, trajectory_of
from gaitflow.search.solution import Solution

ALIKE = 0.9  # correlation with the region's mean
FEWEST = 3  # motions of one pattern that make a region
SCALED = 1.5  # the larger motions are at least so many times the smaller ones

Regions = Mapping[str, Sequence[Solution]]


@dataclass(frozen=True)
class Alikeness:
    """A region's motions against their mean, each coordinate of Fig. 6 (height, pitch, roll, their rates) by itself.

    correlations [n, coordinates]: of each motion with the mean over the cycle's knots, 1 for the same shape whatever
    its size, 0 where one of them is still. scale: how many times the amplitude of the region's 10 % smallest motions
    its 10 % largest have, in the median over coordinates.
    """

    correlations: np.ndarray
    scale: float

    @property
    def alike(self) -> int:
        """How many motions have the shape of the mean in a coordinate, summed over coordinates."""
        return int((self.correlations >= ALIKE).sum())


def alikeness(region: Sequence[Solution]) -> Alikeness | None:
    """Of the motions that share the region's most common pattern; None where they are too few."""
    motions = most_common_pattern(region) if region else []
    if len(motions) < FEWEST:
        return None
    loops = np.array([np.concatenate(planes(trajectory_of(motion).base)) for motion in motions])
    swings = loops - loops.mean(axis=2, keepdims=True)
    mean = swings.mean(axis=0)
    sizes = np.linalg.norm(swings, axis=2)
    both = sizes * np.linalg.norm(mean, axis=1)
    correlations = np.divide((swings * mean).sum(axis=2), both, out=np.zeros_like(both), where=both > 0)
    small, large = np.percentile(sizes, (10, 90), axis=0)
    return Alikeness(correlations, float(np.median(large / np.maximum(small, 1e-12))))


def similar_shapes(regions: Regions) -> Outcome:
    """Share of motions, coordinate by coordinate, that have the shape of their region's mean."""
    found = {name: like for name, region in regions.items() if (like := alikeness(region)) is not None}
    if not found:
        return "not measured", f"no gait has {FEWEST} stored motions of one pattern"
    alike = sum(like.alike for like in found.values())
    whole = sum(like.correlations.size for like in found.values())
    each = ", ".join(f"{name} {like.alike / like.correlations.size:.0%}" for name, like in found.items())
    text = f"{counted_share(alike, whole, 'loops')} correlate with their region's mean by {ALIKE:g} or more: {each}"
    return verdict_of(alike / whole), text


def scaled_shape(gait: str, regions: Regions) -> Outcome:
    """Share of a gait's motions with the mean's shape, when their size changes."""
    like = alikeness(regions.get(gait, ()))
    if like is None:
        return "not measured", f"{gait} has fewer than {FEWEST} stored motions of one pattern"
    text = f"{counted_share(like.alike, like.correlations.size, 'loops')} of {gait} have the mean's shape; "
    text += f"the largest are {like.scale:.1f} times the smallest"
    return ("does not" if like.scale < SCALED else verdict_of(like.alike / like.correlations.size)), text
