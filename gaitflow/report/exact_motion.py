"""Euler's published maps beside the exact ones: pictures, and how many labels the integrator decided."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from gaitflow.config.scenario import Scenario
from gaitflow.core.legacy import modern_scenario
from gaitflow.dataset.legacy import modern_names
from gaitflow.files import atomic_write
from gaitflow.report.claims import Claim, check_claims
from gaitflow.report.map_tasks import newest_grid
from gaitflow.report.report import png_of
from gaitflow.report.side_by_side import LabelledMap, compare, draw_side_by_side
from gaitflow.report.tables import percent

PAIRS = {  # scenario of forward Euler: that of the exact motion
    "half-cheetah-flat-effort": "half-cheetah-exact-effort",
    "half-cheetah-flat-vibration": "half-cheetah-exact-vibration",
    "half-cheetah-slope20-vibration": "half-cheetah-exact-slope20-vibration",
    "anymal-flat-vibration": "anymal-exact-vibration",
    "go1-flat-vibration": "go1-exact-vibration",
}
PAGE = "exact-motion.md"
TITLES = ("map", "tasks of both", "label changed", "beyond ties", "Euler's gait dearer by, median", "at worst", "none")


def write_exact_motion(datasets: Path, docs: Path) -> list[Path]:
    """Write docs/images/exact-<scenario>.png for every pair that is published, and docs/results/exact-motion.md.

    `datasets` holds the published datasets; their newest grids are compared. Raises ValueError when no pair is
    there, WriteError when the disk refuses.
    """
    written, rows, labels = [], [], dict[str, pd.DataFrame]()
    for name, exact_name in PAIRS.items():
        euler, exact = (published_map(datasets / each) for each in (name, exact_name))
        labels |= {each.scenario.name: each.labels for each in (euler, exact) if each is not None}
        if euler is None or exact is None:
            continue
        rows.append(_row(name, compare(euler, exact), exact.scenario.learning.tie_tolerance))
        written.append(docs / "images" / f"exact-{name}.png")
        atomic_write(written[-1], png_of(draw_side_by_side(euler, exact, name)))
    if not rows:
        raise ValueError(f"{datasets}: holds no map of forward Euler beside its exact one; publish one of each first")
    written.append(docs / "results" / PAGE)
    atomic_write(written[-1], page(rows, check_claims(labels, {})).encode())
    return written


def published_map(folder: Path) -> LabelledMap | None:
    """The newest published grid of a scenario; None where there is none."""
    import pyarrow.parquet as pq

    from gaitflow.dataset.read import FILE_NAME
    from gaitflow.publishing.dataset_facts import GAIT_COSTS
    from gaitflow.tables.provenance import read_record

    newest = newest_grid(folder)
    if newest is None:
        return None
    version, labels = newest
    record = read_record(pq.read_metadata(version / FILE_NAME).metadata, str(version / FILE_NAME))
    scenario = Scenario.from_data(modern_scenario(record["scenario"]), str(version))
    costs = modern_names(pq.read_table(version / GAIT_COSTS)).to_pandas()
    return LabelledMap(scenario, labels, costs)


def _row(name: str, found: pd.DataFrame, tolerance: float) -> tuple[str, ...]:
    changed = found[found["changed"]]
    beyond = changed[~(changed["excess"] <= tolerance)]  # one without a motion is no tie
    known = beyond["excess"].dropna()
    return (
        f"{name} / {PAIRS[name]}",
        str(len(found)),
        str(len(changed)),
        str(len(beyond)),
        percent(float(known.median())) if len(known) else "–",
        percent(float(known.max())) if len(known) else "–",
        str(int(beyond["excess"].isna().sum())),
    )


def page(rows: Sequence[tuple[str, ...]], claims: Sequence[Claim]) -> str:
    """The Markdown page: how many labels changed, the statements whose verdict did, and the pictures."""
    differ = [one for one in claims if one.verdict != one.exact_verdict and one.exact_verdict != "not measured"]
    lines = [
        "# What forward Euler decided",
        "",
        "`gaitflow report --exact-motion` writes this page from the newest published datasets. A label changed when",
        "the exact map gives a task another gait; a gait and its time reversal count as one where the exact map",
        "merges them. *Beyond ties* leaves out tasks where Euler's gait ties by the exact costs. The columns after it",
        "are about the tasks that remain: how much dearer Euler's gait is by the exact costs, and how often it has no",
        "motion.",
        "",
        f"| {' | '.join(TITLES)} |",
        f"|{' --- |' * len(TITLES)}",
        *(f"| {' | '.join(row)} |" for row in rows),
        "",
        "## Statements of the paper whose verdict changed",
        "",
        "| id | the paper's statement | forward Euler | exact motion |",
        "| --- | --- | --- | --- |",
        *(f"| {one.id} | {one.statement} | {one.verdict} | {one.exact_verdict} |" for one in differ),
        "",
        "## Side by side",
        "",
    ]
    for row in rows:
        name = row[0].split(" / ")[0]
        lines += [f"![{name}](../images/exact-{name}.png)", ""]
    return "\n".join(lines)
