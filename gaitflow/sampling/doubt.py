"""Where a map is least sure of its pick, and which tasks are searched next.

A place is worth a search by how far it is from every searched task, times how wrong the pick may be there:

    distance * (EVERYWHERE + possible regret + regret seen near by)

The distance counts in steps of the grid. The possible regret is by how much the pick may be dearer than another gait
when both costs are off by as much as their nodes disagree: it is large where costs cross or sheets are torn, and 1
where no gait is known well enough to be believed, at the edges of what is feasible. The regret seen near by is what the
picks of searched tasks had cost before these were searched: it is large where a gait had been missing.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from scipy.spatial import cKDTree
from scipy.stats import qmc

from gaitflow.core.trajectory import Array
from gaitflow.runtime.atlas import SUPPORT, Atlas

EVERYWHERE = 0.01  # what a pick is taken to be off by where nothing speaks against it
WORST = 1.0  # regrets beyond it, and gaits without a motion, count as this
NEAR_BY = 4  # searched tasks whose regret speaks for a place
CANDIDATES = 2048
AT_LEAST = 1e-3  # steps: of a distance that something is divided by


def possible_regret(atlas: Atlas, place: Array, picked: Collection[int]) -> float:
    """By how much, as a share, the pick at a place may be too dear; WORST where the atlas knows too little.

    `picked` are the numbers of the gaits that the map picks from. Another one that may cost less is missing.
    """
    ranked = [sheet for sheet in atlas.ranked(place) if atlas.sheets[sheet].gait in picked]
    if not ranked:
        return WORST
    costs, support = atlas.costs(place)
    if support[ranked[0]] < SUPPORT:
        return WORST
    least = atlas.least_costs(place)
    pick = atlas.sheets[ranked[0]].gait
    others = [least[number] for number, sheet in enumerate(atlas.sheets) if sheet.gait != pick]
    rival = min(others, default=np.inf)
    # What a cost may be above its prediction is as much as it may be below.
    most = costs[ranked[0]] ** 2 / least[ranked[0]]
    return float(np.clip(np.log(most / rival), 0.0, WORST)) if np.isfinite(rival) else 0.0


def next_places(
    atlas: Atlas,
    picked: Collection[int],
    searched: Array,
    regrets: Array,
    low: Array,
    high: Array,
    number: int,
    seed: int,
) -> list[tuple[float, ...]]:
    """The places [a] to be searched next, `number` of them, in the box from `low` to `high`.

    `picked` are the numbers of the gaits that the map picks from. searched [n, a] are the places that were, regrets [n]
    what the picks there had cost too much before that. Each place is taken as searched when the next one is chosen, so
    they lie apart. Equal arguments give equal places.
    """
    unit = qmc.Sobol(len(low), rng=seed).random(CANDIDATES)
    candidates = low + unit * (high - low)
    wrong = np.array([possible_regret(atlas, place, picked) for place in candidates])
    known = searched / atlas.steps
    tree = cKDTree(known)
    places = candidates / atlas.steps
    distances, nearest = tree.query(places, k=range(1, min(NEAR_BY, len(known)) + 1))
    weights = 1 / np.maximum(distances, AT_LEAST)
    seen = (weights * np.minimum(regrets, WORST)[nearest]).sum(axis=1) / weights.sum(axis=1)
    worth, away = EVERYWHERE + wrong + seen, distances[:, 0]
    chosen = []
    for _ in range(number):
        best = int(np.argmax(away * worth))
        chosen.append(best)
        away = np.minimum(away, np.linalg.norm(places - places[best], axis=1))
    return [tuple(place) for place in candidates[chosen].round(6).tolist()]


def mean_regret(regrets: Sequence[float]) -> float:
    """The mean of regrets as they count here; 0 without any."""
    return float(np.minimum(regrets, WORST).mean()) if len(regrets) else 0.0
