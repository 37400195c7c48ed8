"""The report of one scenario: its figures as PNG files and one page that holds them all."""

from __future__ import annotations

import io
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from gaitflow.config.scenario import Scenario
from gaitflow.core.task import AXES
from gaitflow.files import atomic_write
from gaitflow.report import axis_text
from gaitflow.report.gait_diagrams import draw_gait_diagrams
from gaitflow.report.gait_map import draw_gait_map
from gaitflow.report.interactive_map import interactive_map
from gaitflow.report.map_panel import Select
from gaitflow.report.motion import draw_motion
from gaitflow.report.page import Picture, Section, render_page
from gaitflow.report.palette import gait_colours
from gaitflow.report.slices import slices_of
from gaitflow.report.state_space import draw_state_space
from gaitflow.report.tables import (
    Table,
    between_knots_table,
    check_table,
    effort_table,
    gait_table,
    learning_table,
    number,
    percent,
    provenance_table,
    refined,
    tie_table,
    unresolved_table,
    unsolved_table,
)
from gaitflow.report.winners import by_size, central, winners
from gaitflow.search.solution import Solution

PAGE = "index.html"
ALONE = "Drawn from the map alone: tasks, costs and margins are what it predicts on its grid."
MAX_GAITS = 12  # gaits drawn in detail, those that win most tasks


def write_report(
    folder: Path,
    scenario: Scenario,
    labels: pd.DataFrame,
    solutions: Sequence[Solution],
    gaits: Sequence[str],
    select: Select | None,
    learning: Mapping[str, Any] | None,
    record: Mapping[str, Any] | None,
) -> list[Path]:
    """Write map.png, gaits.png, state_space.png, a motion-<gait>.png a gait and index.html; return their paths.

    `labels` is the labels frame (`gaitflow.dataset.labels`), `select` the map's decision as an index into `gaits`, from
    the values of each axis with a range, `learning` the data of `Training.as_data()`, `record` the dataset's
    provenance. `select` and `learning` are None when no classifier was trained, `record` where no dataset is at hand.
    Raises ValueError when `labels` is empty, WriteError when the disk refuses.
    """
    space = scenario.tasks.space
    regions = winners(labels, solutions, space)
    shown = {name: regions[name] for name in by_size(labels)[:MAX_GAITS] if regions[name]}
    colours = gait_colours([*gaits, *regions])
    figures = {"map": draw_gait_map(labels, gaits, select, scenario.description or scenario.name, space)}
    motions = {}
    if shown:
        figures["gaits"] = draw_gait_diagrams(shown, scenario.robot.leg_names, colours)
        figures["state_space"] = draw_state_space(shown, space)
        motions = {
            f"motion-{_slug(name, place)}": draw_motion(central(region), scenario, name, colours[name])
            for place, (name, region) in enumerate(shown.items())
        }
    images = {name: png_of(figure) for name, figure in (figures | motions).items()}
    html = render_page(
        scenario.name,
        scenario.description,
        _highlights(labels, learning),
        _sections(scenario, labels, solutions, regions, learning, record, images, tuple(motions)),
        interactive_map(labels, solutions, scenario, gaits, select),
    )
    files = {f"{name}.png": image for name, image in images.items()} | {PAGE: html.encode("utf-8")}
    for name, content in files.items():
        atomic_write(folder / name, content)
    return [folder / name for name in files]


def png_of(figure: Figure) -> bytes:
    """The figure as PNG at 150 dpi, without a time stamp so that equal figures have equal bytes."""
    buffer = io.BytesIO()
    FigureCanvasAgg(figure)
    figure.savefig(buffer, format="png", dpi=150, facecolor="white", metadata={"Software": "gaitflow"})
    return buffer.getvalue()


def _slug(name: str, place: int) -> str:
    # A gait called by its diagram has no file name of its own.
    return re.sub(r"[ /]", "-", name) if re.fullmatch(r"[a-z]+([ -][a-z]+)*( [01/]+)?", name) else f"{place + 1}"


def _highlights(labels: pd.DataFrame, learning: Mapping[str, Any] | None) -> list[tuple[str, str]]:
    solved = labels[labels["status"] == "solved"]
    pairs = [
        ("grid tasks", str(int((labels["split"] == "grid").sum()))),
        ("held-out tasks", str(int((labels["split"] != "grid").sum()))),
        ("gaits that win somewhere", str(solved["gait"].nunique())),
        ("tasks without a gait", str(len(labels) - len(solved))),
        ("tasks with ties", str(int((labels["ties"].map(len) > 1).sum()))),
    ]
    if refined(labels):
        pairs += [("labels not resolved", str(int((~solved["resolved"].astype(bool)).sum())))]
    if learning is not None:
        quality = next(one for one in learning["competitors"] if one["method"] == learning["method"])
        judged = quality["held_out"] if quality["held_out"]["tasks"] else quality["cross_validation"]
        pairs += [("classifier published", learning["method"]), ("mean cost regret", percent(judged["regret_mean"]))]
    return pairs


def _sections(
    scenario: Scenario,
    labels: pd.DataFrame,
    solutions: Sequence[Solution],
    regions: Mapping[str, Sequence[Solution]],
    learning: Mapping[str, Any] | None,
    record: Mapping[str, Any] | None,
    images: Mapping[str, bytes],
    motions: Sequence[str],
) -> list[Section]:
    def pictures(*names: str, caption: str = "") -> tuple[Picture, ...]:
        return tuple(Picture(images[name], name, caption) for name in names if name in images)

    space, data = scenario.tasks.space, scenario.as_data()
    ties, missing, unresolved = (table(labels, space) for table in (tie_table, unsolved_table, unresolved_table))
    labelled = [solution for region in regions.values() for solution in region]
    chosen = "Regions: the map's choice. Markers: the gait that costs least."
    tolerance = percent(scenario.learning.tie_tolerance)
    none = f"No task has gaits within {tolerance} of each other."
    judged = ("No classifier was trained.",)
    if learning is not None:
        numbers = "Numbers are on the cross-validation folds / on the held-out tasks; the published method is marked."
        judged = (f"How the winner is chosen: {learning['rule']}", numbers, *learning["remarks"])
    told = (ALONE,) if record is None else ()
    shown = [
        Section("The scenario", _in_words(scenario)),
        Section(
            "Gait map",
            told,
            pictures=pictures("map", caption=f"{chosen} {slices_of(labels, space).remark}".strip()),
        ),
        Section(
            "Gaits",
            ("The margin is how much dearer the next best gait is.",),
            pictures("gaits", caption="When each leg stands, with the mean phase durations of the gait's tasks."),
            gait_table(labels, scenario.robot.leg_names),
        ),
    ]
    learnt = [
        Section("Classifiers", judged, table=None if learning is None else learning_table(learning)),
        Section("Ties", (f"Gaits within {tolerance} of the least cost tie." if ties.rows else none,), table=ties),
    ]
    lacking = Section(
        "Tasks without a gait",
        () if missing.rows else ("A gait was found for every task.",),
        table=missing,
    )
    if record is None:
        return [*shown, *learnt, lacking]
    return [
        *shown,
        Section(
            "State space",
            ("Trajectories of one gait look alike, which is why their mean is a good start for an optimiser.",),
            pictures("state_space", caption="A line a task; bold is the mean of the gait's most common pattern."),
        ),
        Section(
            "Motions",
            ("The task nearest the middle of each region. Red arrows are contact forces.",),
            pictures(*motions),
        ),
        *learnt,
        Section(
            "Labels that the mesh leaves open",
            (_on_resolution(labels, unresolved),),
            table=unresolved,
        ),
        lacking,
        Section(
            "Every label checked again",
            (
                f"{len(labelled)} of {int((labels['status'] == 'solved').sum())} labelled motions, each judged anew by "
                "an integrator and constraints that share no code with the solver's problem; values are scaled: forces "
                "by the robot's weight, lengths by a metre, times by the cycle.",
            ),
            table=check_table(data, labelled),
        ),
        Section(
            "Between the knots",
            (
                "The same motions on a grid ten times finer: how far the stored states are from the continuous motion "
                "under the same forces [m or rad], and the constraints that no knot sees (friction over the robot's "
                "weight, the others in m).",
            ),
            table=between_knots_table(data, labelled),
        ),
        Section("Solves", table=effort_table(solutions)),
        Section("Provenance", table=provenance_table(record)),
    ]


def _on_resolution(labels: pd.DataFrame, unresolved: Table) -> str:
    if not refined(labels):
        return "The costs were not compared with those on a finer mesh."
    if unresolved.rows:
        return "The margin is smaller than the error that a finer mesh shows, or none was asked; the gaits do not tie."
    return "Every margin is larger than the errors of the costs behind it, by a finer mesh, or the gaits tie."


def _in_words(scenario: Scenario) -> tuple[str, ...]:
    robot, settings, tasks = scenario.robot, scenario.transcription, scenario.tasks
    weights = {name.replace("_", " "): weight for name, weight in scenario.objective.as_data().items() if weight}
    stances = "any number of stances" if scenario.stances_per_leg is None else "one stance"
    ranges = [
        f"{values.count} values of {axis_text.words(axis)} from {values.start:g} to "
        f"{axis_text.quantity(axis, values.stop)}"
        for axis, values in tasks.ranges.items()
    ]
    # The ground is always told, of the other axes only what is not as usual.
    fixed = [
        f"{axis_text.words(axis)} {axis_text.quantity(axis, value)}"
        for axis, value in _fixed(scenario).items()
        if axis in ("slope", "friction") or value != AXES[axis].default
    ]
    return (
        f"Robot {robot.name}: {number(robot.mass)} kg, {len(robot.legs)} legs ({', '.join(robot.leg_names)}), "
        f"{robot.dimension}D.",
        "Objective, weight by term: " + ", ".join(f"{name} {weight:g}" for name, weight in weights.items()) + ".",
        f"{settings.phases} phases of {settings.knots_per_phase} knots, integrated by "
        f"{settings.integrator.replace('_', '-')} with {settings.forces} forces, "
        f"each phase at least {percent(settings.min_phase_fraction)} of the cycle; {stances} a leg and cycle.",
        f"Tasks: {' by '.join(ranges)}, and {tasks.held_out} held-out tasks between. "
        + (f"The same for all: {', '.join(fixed)}. " if fixed else "")
        + f"Search: {scenario.strategy.name}.",
    )


def _fixed(scenario: Scenario) -> dict[str, float]:
    """The values of the axes without a range."""
    space = scenario.tasks.space
    given = dict(space.fixed)
    return {
        name: given.get(name, axis.default or 0.0)
        for name, axis in AXES.items()
        if name not in space.ranged and not (axis.spatial and scenario.robot.dimension == 2)
    }
