"""Measures of the statements of section IV on labelled task grids; `gaitflow.report.claims` states the rules."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Literal

import numpy as np
import pandas as pd

from gaitflow.report.regions import GaitGrid, Mask

HOLDS, IN_PART = 0.8, 0.4  # shares of tasks or of conditions
SMALL = 0.1  # a small region covers at most this share of the feasible grid
DIFFERENT, SOMEWHAT_DIFFERENT = 0.2, 0.1  # share of tasks whose gait changes between two scenarios
FIG5 = ("walking", "gallop", "bounding", "pronking", "gallop-walk", "gallop-pronk", "gallop-bound")

Verdict = Literal["holds", "holds in part", "does not", "not measured"]
Outcome = tuple[Verdict, str]  # and the numbers behind it


def verdict_of(share: float) -> Verdict:
    """The verdict on a share of tasks or of conditions, between 0 and 1; NaN (nothing to count) does not hold."""
    if share >= HOLDS:
        return "holds"
    return "holds in part" if share >= IN_PART else "does not"


def _all_of(conditions: Mapping[str, bool]) -> Outcome:
    met = sum(conditions.values()) / len(conditions)
    text = "; ".join(f"{name}: {'yes' if value else 'no'}" for name, value in conditions.items())
    return ("holds" if met == 1 else "holds in part" if met >= IN_PART else "does not"), text


def counted_share(inside: int, total: int, things: str) -> str:
    """ "3 of 4 tasks (75%)"."""
    return f"{inside} of {total} {things}" + (f" ({inside / total:.0%})" if total else "")


def _count(part: Mask, whole: Mask) -> str:
    return counted_share(int((part & whole).sum()), int(whole.sum()), "tasks")


def _share(part: Mask, whole: Mask) -> float:
    return float((part & whole).sum() / whole.sum()) if whole.any() else float("nan")


def _prevails(grid: GaitGrid, gait: str, window: Mask) -> Outcome:
    """How much of the window belongs to the gait, and what else is there."""
    if not window.any():
        return "not measured", "no feasible grid task in the stated window"
    text = f"{gait} best at {_count(grid.best(gait), window)}, {_count(grid.best_or_tied(gait), window)} with ties"
    others = pd.Series(grid.gaits[window & ~grid.best(gait)]).value_counts()
    if len(others):
        text += "; others: " + ", ".join(f"{name} {count}" for name, count in others.items())
    return verdict_of(_share(grid.best(gait), window)), text


def _bordering(grid: GaitGrid, gait: str, sides: tuple[str, str]) -> Mask:
    """Tasks of the gait in regions that touch both sides."""
    mask = np.zeros(grid.gaits.shape, dtype=bool)
    for region in grid.regions(gait):
        if grid.borders(region).issuperset(sides):
            mask |= region
    return mask


def walking_when_very_slow(a: GaitGrid) -> Outcome:
    """Share of walking up to 0.3 m/s."""
    return _prevails(a, "walking", a.window(speed=(-np.inf, 0.3)))


def gallop_walk_when_slow(a: GaitGrid) -> Outcome:
    """Share of gallop-walk from 0.5 to 0.7 m/s."""
    return _prevails(a, "gallop-walk", a.window(speed=(0.5, 0.7)))


def _bounding_window(a: GaitGrid) -> Mask:
    return a.window(speed=(1.7, 2.3), duration=(1.2, 1.6))


def gallop_from_medium_speed(a: GaitGrid) -> Outcome:
    """Share of gallop from 0.9 m/s on, without the window in which the paper sees bounding."""
    return _prevails(a, "gallop", a.window(speed=(0.9, np.inf)) & ~_bounding_window(a))


def bounding_when_fast_and_long(a: GaitGrid) -> Outcome:
    """Share of bounding at 1.7 to 2.3 m/s and 1.2 to 1.6 s."""
    return _prevails(a, "bounding", _bounding_window(a))


def two_small_regions(a: GaitGrid) -> Outcome:
    """Pronking and gallop-bound: each there, small, and in one piece."""
    conditions = {}
    for gait in ("pronking", "gallop-bound"):
        regions, share = a.regions(gait), _share(a.best(gait), a.feasible)
        conditions[f"{gait} appears ({_count(a.best(gait), a.feasible)})"] = bool(regions)
        conditions[f"{gait} covers at most {SMALL:.0%}"] = bool(regions) and share <= SMALL
        conditions[f"{gait} is one region ({len(regions)})"] = len(regions) == 1
    verdict, text = _all_of(conditions)
    return verdict, f"{text} (gallop-pronk: {_count(a.best('gallop-pronk'), a.feasible)})"


def at_transition(gait: str, sides: tuple[str, str]) -> Callable[[GaitGrid], Outcome]:
    """Share of the gait's tasks that lie in regions between both sides."""

    def measure(a: GaitGrid) -> Outcome:
        whole, part = a.best(gait), _bordering(a, gait, sides)
        text = f"{_count(part, whole)} of {gait} in regions that touch both {sides[0]} and {sides[1]}"
        return verdict_of(_share(part, whole)), text

    return measure


def only_gaits_of_fig5(a: GaitGrid) -> Outcome:
    """How many of the gaits found are in Fig. 5; holds when all are."""
    strangers = [name for name in a.names if name not in FIG5]
    inside = np.isin(a.gaits.astype(str), FIG5)
    text = f"{len(a.names) - len(strangers)} of {len(a.names)} gaits, {_count(inside, a.feasible)}"
    text += "; not in Fig. 5: " + ", ".join(strangers) if strangers else ""
    share = 1 - len(strangers) / len(a.names) if a.names else float("nan")
    return ("holds" if share == 1 else "holds in part" if share >= IN_PART else "does not"), text


def every_gait_of_fig5(*grids: GaitGrid) -> Outcome:
    """Whether each gait of Fig. 5 is best somewhere on any of the maps."""
    return _all_of({name: any(grid.best(name).any() for grid in grids) for name in FIG5})


def contiguous(grid: GaitGrid) -> Outcome:
    """Share of tasks in the largest region of their gait, when at least two regions have more than one task."""
    largest = np.zeros(grid.gaits.shape, dtype=bool)
    components = sizeable = 0
    for name in grid.names:
        regions = grid.regions(name)
        largest |= regions[0]
        components += len(regions)
        sizeable += sum(int(region.sum()) > 1 for region in regions)
    text = f"{_count(largest, grid.feasible)} in the largest region of their gait; "
    text += f"{components} regions of {len(grid.names)} gaits, {sizeable} of more than one task"
    return ("does not" if sizeable < 2 else verdict_of(_share(largest, grid.feasible))), text


def same_regions(a: GaitGrid, b: GaitGrid) -> Outcome:
    """Overlap (intersection over union) of the second best preserved gait: "some regions" are at least two."""
    a, b = _shared(a, b)
    overlaps = {}
    for name in sorted(set(a.names) & set(b.names)):
        both, either = a.best(name) & b.best(name), a.best(name) | b.best(name)
        overlaps[name] = float(both.sum() / either.sum())
    ranked = sorted(overlaps.items(), key=lambda item: -item[1])
    second = ranked[1][1] if len(ranked) > 1 else float("nan")
    text = f"same gait at {_count(a.gaits == b.gaits, a.feasible & b.feasible)}; overlap of regions: "
    return verdict_of(second), text + (", ".join(f"{name} {value:.0%}" for name, value in ranked) or "none")


def bounding_at_medium_speed(b: GaitGrid) -> Outcome:
    """Share of bounding in the middle third of speeds, and the durations at which it has the majority."""
    window = b.window(speed=b.third("speed", 1))
    verdict, text = _prevails(b, "bounding", window)
    led = [f"{T:g}" for T in b.durations if _share(b.best("bounding"), window & b.window(duration=(T, T))) > 0.5]
    return verdict, f"{text}; bounding has most speeds at T = {', '.join(led) or 'no duration'} s"


def increased_at_border(gait: str, sides: tuple[str, str]) -> Callable[[GaitGrid, GaitGrid], Outcome]:
    """Share of the gait's tasks in regions that touch both sides, when it has more tasks than before."""

    def measure(before: GaitGrid, after: GaitGrid) -> Outcome:
        before, after = _shared(before, after)
        counts = int(before.best(gait).sum()), int(after.best(gait).sum())
        text = f"{gait}: {counts[0]} tasks before, {counts[1]} after; "
        text += f"{_count(_bordering(after, gait, sides), after.best(gait))} in regions touching {' and '.join(sides)}"
        if counts[1] <= counts[0]:
            return "does not", text
        return verdict_of(_share(_bordering(after, gait, sides), after.best(gait))), text

    return measure


def gallop_walk_at_low_speed(b: GaitGrid) -> Outcome:
    """Share of gallop-walk in the lower third of speeds."""
    return _prevails(b, "gallop-walk", b.window(speed=b.third("speed", 0)))


def bounding_replaced(b: GaitGrid, c: GaitGrid) -> Outcome:
    """Share of gallop on the slope, of the tasks at medium speed and low T that flat ground gives to bounding."""
    speeds, durations = b.third("speed", 1), b.third("duration", 0)
    b, c = _shared(b, c)
    window = b.window(speeds, durations) & b.best("bounding")
    if not window.any():
        return "does not", "no bounding at medium speed and low cycle duration on flat ground to replace"
    return _prevails(c, "gallop", window & c.feasible)


def distinct(a: GaitGrid, b: GaitGrid, c: GaitGrid) -> Outcome:
    """Least share of tasks that change their gait, over the pairs of scenarios."""
    shares, texts = [], []
    for (one, first), (two, second) in ((("4a", a), ("4b", b)), (("4b", b), ("4c", c)), (("4a", a), ("4c", c))):
        first, second = _shared(first, second)
        whole, changed = first.feasible & second.feasible, first.gaits != second.gaits
        shares.append(_share(changed, whole))
        texts.append(f"{one} to {two}: gait differs at {_count(changed, whole)}")
    least = min(shares)
    verdict: Verdict = "holds" if least >= DIFFERENT else "holds in part" if least >= SOMEWHAT_DIFFERENT else "does not"
    return verdict, "; ".join(texts)


def no_flight_when_slow(grid: GaitGrid) -> Outcome:
    """Share of gaits without flight in the lower third of speeds."""
    window = grid.window(speed=grid.third("speed", 0))
    return verdict_of(_share(~grid.flies, window)), f"no flight at {_count(~grid.flies, window)}"


def flight_when_fast(grid: GaitGrid) -> Outcome:
    """Share of gaits with flight in the upper third of speeds."""
    window = grid.window(speed=grid.third("speed", 2))
    return verdict_of(_share(grid.flies, window)), f"flight at {_count(grid.flies, window)}"


def running_trot_and_pace(grid: GaitGrid) -> Outcome:
    """Whether both are best somewhere in the upper third of speeds, each by any of its gaits."""
    window = grid.window(speed=grid.third("speed", 2))
    conditions = {}
    for kind in ("running trot", "running pace"):
        named = np.array([[str(name).startswith(kind) for name in row] for row in grid.gaits], dtype=bool)
        conditions[f"{kind} ({_count(named, window)})"] = bool((named & window).any())
    return _all_of(conditions)


def more_gaits(*grids: GaitGrid) -> Outcome:
    """Whether the last map has more gaits than the others have together."""
    before, after = {name for grid in grids[:-1] for name in grid.names}, grids[-1].names
    text = f"{len(after)} gaits, {len(before)} in Fig. 4a-c together"
    return ("holds" if len(after) > len(before) else "does not"), text


def _shared(one: GaitGrid, two: GaitGrid) -> tuple[GaitGrid, GaitGrid]:
    """Both maps on the tasks that both grids contain."""
    speeds = np.intersect1d(one.speeds, two.speeds)
    durations = np.intersect1d(one.durations, two.durations)
    return one.at(speeds, durations), two.at(speeds, durations)
