"""Which patterns get a sheet in an atlas: as few as possible that are the best of their gait wherever it matters.

A gait may have several patterns (AABC, ABBC, ABCC), and which of them costs least depends on the task.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable

import pandas as pd

from gaitflow.config.scenario import Scenario
from gaitflow.config.tasks import grid_of
from gaitflow.core.gaits import Pattern, Symmetry, gait_of
from gaitflow.dataset.labels import MAX_VIOLATION
from gaitflow.tables.schema import task_columns

NEARLY_BEST = 0.02  # relative: a gait matters at tasks of the grid where it is at most this much dearer than the best;
NEARLY_BEST_WIDE = 0.005  # in a map of more axes than three, where so many gaits are nearly the best somewhere


def map_symmetry(scenario: Scenario) -> Symmetry:
    """Which patterns are one gait everywhere in a map: the images under which all of its tasks stay as they are.

    On level ground a gait run backwards may be the same one; in a map of many slopes it is not.
    """
    each = {scenario.symmetry(task) for task in grid_of(scenario)}
    mirrors, reversals = {one.mirror for one in each}, {one.reversal for one in each}
    return Symmetry(
        mirrors.pop() if len(mirrors) == 1 else None,
        reversals.pop() if len(reversals) == 1 else None,
    )


def nearly_best(axes: int) -> float:
    """By how much, as a share, a gait may be dearer than the best where it matters, in a map of so many axes."""
    return NEARLY_BEST if axes <= 3 else NEARLY_BEST_WIDE


def full_patterns(
    solutions: pd.DataFrame,
    costs: pd.DataFrame,
    gaits: Iterable[str],
    tolerance: float,
    symmetry: Symmetry,
    taken: Collection[str] = (),
) -> dict[str, str]:
    """Patterns and the gaits that they realise, of the `gaits` only, sorted by gait.

    `solutions` are the scalars of the dataset, `costs` the frame of `gaitflow.dataset.labels.gait_costs`. At every task
    that is not held out where a gait matters one of its patterns is at most `tolerance` (relative) dearer than its best
    one. Patterns of `taken`, which an atlas has already, come first. `symmetry` is the map's: a pattern that is another
    gait at other tasks of the map is left out.
    """
    task = task_columns(costs.columns)
    band = nearly_best(len(task) - 1)
    kept = (solutions["status"] == "solved") & (solutions["violation"] <= MAX_VIOLATION)
    rows = solutions[kept & (solutions["split"] != "held_out")]
    least = rows.groupby([*task, "gait", "pattern"], sort=False)["cost"].min().reset_index()
    best = least.groupby([*task, "gait"])["cost"].transform("min")
    good = least[least["cost"] <= best * (1 + tolerance)]
    keys = {pattern: gait_of(Pattern.from_text(pattern), symmetry).text for pattern in good["pattern"].unique()}
    good = good[good["pattern"].map(keys) == good["gait"]]
    matters = costs[(costs["split"] != "held_out") & (costs["excess"] <= band)]
    chosen: dict[str, str] = {}
    for name in sorted(set(gaits)):
        wanted = matters[matters["gait"] == name]
        covering = good.merge(wanted[[*task, "gait_key"]], left_on=[*task, "gait"], right_on=[*task, "gait_key"])
        places = covering[task].itertuples(index=False, name=None)
        by_pattern: dict[str, set[tuple[float | str, ...]]] = {}
        for pattern, place in zip(covering["pattern"], places, strict=True):
            by_pattern.setdefault(pattern, set()).add(place)
        for pattern in _cover(by_pattern, taken):
            chosen[pattern] = name
    return chosen


def _cover(sets: dict[str, set[tuple[float | str, ...]]], first: Collection[str]) -> list[str]:
    """Names of few sets that have everything in any of them: all of `first`, then by taking what adds most.

    The first name of equal ones.
    """
    taken = [name for name in sorted(sets) if name in first]
    missing = set[tuple[float | str, ...]]().union(*sets.values()).difference(*(sets[name] for name in taken))
    while missing:
        name = min(sets, key=lambda each: (-len(sets[each] & missing), each))
        taken.append(name)
        missing -= sets[name]
    return taken
