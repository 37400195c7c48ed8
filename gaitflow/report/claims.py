"""Every statement of section IV on its maps, measured on labelled task grids and their motions by fixed rules.

The rules are a literal reading of the paper's sentences; those on section IV.A were written before this package
computed a map.

- Only grid tasks count. A task counts for the gait that costs least there; the share that includes ties within the
  tolerance is reported beside it, and decides nothing.
- A share of tasks holds from 80 % on, in part from 40 % on, and otherwise does not hold.
- A statement that joins several conditions holds when all of them are met, in part when 40 % of them are.
- A small region covers at most 10 % of the tasks. Two maps differ sufficiently when 20 % of the tasks change their
  gait, in part when 10 % do.
- Where the paper gives no numbers, low and medium speeds are the lower and middle third of the grid's range, and low
  cycle durations the lower third. Regions touch along an edge of the grid, not at a corner.
- "Pronking" is gait d of Fig. 5 alone; gallop-pronk, which the text does not mention, is counted apart.
- A statement about a gait that never appears does not hold; one whose scenario or window is missing is not measured.
- Motions of a region are similar where a coordinate of Fig. 6 (height, pitch, in space roll, and their rates) over the
  cycle's knots correlates by 0.9 with the mean of the region's motions of one pattern.

Each statement is measured twice: on the maps of the paper's forward Euler, and on those of the exact motion. There a
gait and its time reversal are one on flat ground. Of Fig. 5 that is so for pronking and gallop-pronk: in the exact
maps, on the slope as well so that maps can be compared, the two names count as one gait.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import pandas as pd

from gaitflow.report import measures
from gaitflow.report.measures import Outcome, Verdict
from gaitflow.report.regions import GaitGrid
from gaitflow.report.similarity import Regions, scaled_shape, similar_shapes

FIGURES = {
    "4a": "half-cheetah-flat-effort",
    "4b": "half-cheetah-flat-vibration",
    "4c": "half-cheetah-slope20-vibration",
    "7": "anymal-flat-vibration",
}

EXACT = {
    "4a": "half-cheetah-exact-effort",
    "4b": "half-cheetah-exact-vibration",
    "4c": "half-cheetah-exact-slope20-vibration",
    "7": "anymal-exact-vibration",
}
SCENARIOS = (*FIGURES.values(), *EXACT.values())
REVERSED = {"pronking": "gallop-pronk"}

Grids = Mapping[str, GaitGrid]


@dataclass(frozen=True)
class Claim:
    """One statement of the paper and what our maps say about it: those of forward Euler, and the exact ones."""

    id: str
    statement: str
    verdict: Verdict
    numbers: str
    exact_verdict: Verdict
    exact_numbers: str


@dataclass(frozen=True)
class _Check:
    id: str
    statement: str
    needs: tuple[str, ...]  # figures
    measure: Callable[..., Outcome]  # one GaitGrid per needed figure, or one Regions
    on_motions: bool = False


def check_claims(labels: Mapping[str, pd.DataFrame], motions: Mapping[str, Regions]) -> tuple[Claim, ...]:
    """One row per statement; by scenario name (SCENARIOS) labels frames, and the motions that win, by gait.

    A statement whose scenarios are not all given is "not measured" and says which are missing.
    Raises ValueError when a labels frame has no grid task.
    """
    of_euler = _grids(labels, FIGURES, {}), _regions(motions, FIGURES)
    of_exact = _grids(labels, EXACT, REVERSED), _regions(motions, EXACT)
    return tuple(
        Claim(check.id, check.statement, *_outcome(check, *of_euler, FIGURES), *_outcome(check, *of_exact, EXACT))
        for check in CHECKS
    )


def outcomes(labels: Mapping[str, pd.DataFrame], exact: bool) -> dict[str, Outcome]:
    """What each statement that these labels suffice for comes to, by its id; labels of one robot, by figure ("4a").

    Raises ValueError when a labels frame has no grid task.
    """
    merged = REVERSED if exact else {}
    grids = {figure: GaitGrid.from_labels(frame, merged) for figure, frame in labels.items()}
    asked = [check for check in CHECKS if not check.on_motions and grids.keys() >= set(check.needs)]
    return {check.id: check.measure(*(grids[figure] for figure in check.needs)) for check in asked}


def _regions(motions: Mapping[str, Regions], names: Mapping[str, str]) -> Mapping[str, Regions]:
    return {figure: motions[name] for figure, name in names.items() if name in motions}


def _grids(labels: Mapping[str, pd.DataFrame], names: Mapping[str, str], merged: Mapping[str, str]) -> Grids:
    return {figure: GaitGrid.from_labels(labels[name], merged) for figure, name in names.items() if name in labels}


def claims_data(claims: Sequence[Claim]) -> list[dict[str, Any]]:
    """The rows as plain JSON data."""
    return [asdict(claim) for claim in claims]


def claims_markdown(claims: Sequence[Claim], shares: Mapping[str, Mapping[str, str]] | None = None) -> str:
    """The rows as a Markdown table, one line per statement.

    `shares` adds a column a rule of motion: by rule and statement, how many robots of a sweep keep it.
    """
    swept = dict(shares or {})
    titles = ("id", "the paper's statement", "forward Euler", "exact motion", *(f"robots, {rule}" for rule in swept))
    titles = (*titles, "Euler's numbers", "exact numbers")
    lines = [f"| {' | '.join(titles)} |", f"|{' --- |' * len(titles)}"]
    for claim in claims:
        robots = [found.get(claim.id, "") for found in swept.values()]
        cells = (
            claim.id, claim.statement, claim.verdict, claim.exact_verdict, *robots, claim.numbers, claim.exact_numbers,
        )  # fmt: skip
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def _outcome(check: _Check, grids: Grids, motions: Mapping[str, Regions], names: Mapping[str, str]) -> Outcome:
    given: Mapping[str, Any] = motions if check.on_motions else grids
    missing = [f"{names[figure]} (Fig. {figure})" for figure in check.needs if figure not in given]
    if missing:
        return "not measured", "needs " + " and ".join(missing)
    return check.measure(*(given[figure] for figure in check.needs))


CHECKS = (
    _Check(
        "4a-walking",
        "At very low speeds (up to about 0.3 m/s) walking is favoured.",
        ("4a",),
        measures.walking_when_very_slow,
    ),
    _Check(
        "4a-gallop-walk",
        "At 0.5 to 0.7 m/s the model switches to gallop-walk.",
        ("4a",),
        measures.gallop_walk_when_slow,
    ),
    _Check(
        "4a-gallop",
        "From 0.9 m/s on galloping is preferred (but for the next row).",
        ("4a",),
        measures.gallop_from_medium_speed,
    ),
    _Check(
        "4a-bounding",
        "At T = 1.2 to 1.6 s and 1.7 to 2.3 m/s bounding is preferred.",
        ("4a",),
        measures.bounding_when_fast_and_long,
    ),
    _Check("4a-small", "Pronking and gallop-bound cover two small regions only.", ("4a",), measures.two_small_regions),
    _Check(
        "4a-pronking",
        "Pronking appears during the transition from gallop-walk to gallop.",
        ("4a",),
        measures.at_transition("pronking", ("gallop-walk", "gallop")),
    ),
    _Check(
        "4a-gallop-bound",
        "Gallop-bound appears during the transition from gallop to bounding.",
        ("4a",),
        measures.at_transition("gallop-bound", ("gallop", "bounding")),
    ),
    _Check("4a-fig5", "All discovered gaits are described in Fig. 5.", ("4a",), measures.only_gaits_of_fig5),
    _Check(
        "4b-same", "Some regions remain the same as in Fig. 4a (at least two).", ("4a", "4b"), measures.same_regions
    ),
    _Check(
        "4b-bounding",
        "At medium speed and every T bounding is preferred over gallop.",
        ("4b",),
        measures.bounding_at_medium_speed,
    ),
    _Check(
        "4b-gallop-bound",
        "Gallop-bound increases at the borders of gallop and bounding.",
        ("4a", "4b"),
        measures.increased_at_border("gallop-bound", ("gallop", "bounding")),
    ),
    _Check("4b-gallop-walk", "Gallop-walk becomes prevalent at low speed.", ("4b",), measures.gallop_walk_at_low_speed),
    _Check(
        "4c-gallop", "Gallop replaces bounding at low T and medium speed.", ("4b", "4c"), measures.bounding_replaced
    ),
    _Check(
        "4c-pronking",
        "Pronking becomes more prominent on the boundary of gallop and bounding.",
        ("4b", "4c"),
        measures.increased_at_border("pronking", ("gallop", "bounding")),
    ),
    _Check("4-distinct", "Maps differ sufficiently between scenarios.", ("4a", "4b", "4c"), measures.distinct),
    _Check("4-fig5", "The gaits discovered are the seven of Fig. 5.", ("4a", "4b", "4c"), measures.every_gait_of_fig5),
    _Check("4a-contiguous", "Gaits occupy several contiguous regions of Fig. 4a.", ("4a",), measures.contiguous),
    _Check("4b-contiguous", "Gaits occupy several contiguous regions of Fig. 4b.", ("4b",), measures.contiguous),
    _Check("4c-contiguous", "Gaits occupy several contiguous regions of Fig. 4c.", ("4c",), measures.contiguous),
    *(
        _Check(
            f"6-similar-{figure}",
            f"Within a region of Fig. {figure} trajectories look qualitatively similar (IV.B, Fig. 6).",
            (figure,),
            similar_shapes,
            on_motions=True,
        )
        for figure in ("4a", "4b", "4c")
    ),
    _Check("7-structured", "In space, too, gaits occupy several contiguous regions.", ("7",), measures.contiguous),
    _Check("7-no-flight", "At low speeds gaits avoid flying phases.", ("7",), measures.no_flight_when_slow),
    _Check("7-flight", "At higher speeds gaits have noticeable flying phases.", ("7",), measures.flight_when_fast),
    _Check("7-running", "Among them are running trot and pace.", ("7",), measures.running_trot_and_pace),
    _Check(
        "7-more", "The number of gaits is even larger than in the plane.", ("4a", "4b", "4c", "7"), measures.more_gaits
    ),
    _Check(
        "10-shape",
        "Within a region the shape remains and only the scale changes: running trot (IV.C, Fig. 10).",
        ("7",),
        partial(scaled_shape, "running trot"),
        on_motions=True,
    ),
    _Check(
        "10-similar",
        "The same of all regions of Fig. 7.",
        ("7",),
        similar_shapes,
        on_motions=True,
    ),
)
