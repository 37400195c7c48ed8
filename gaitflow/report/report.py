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
from gaitflow.files import atomic_write
from gaitflow.report.certificate import SamplingRecord
from gaitflow.report.decisions import Select
from gaitflow.report.gait_diagrams import draw_gait_diagrams
from gaitflow.report.gait_map import draw_gait_map
from gaitflow.report.interactive_map import interactive_map
from gaitflow.report.motion import draw_motion
from gaitflow.report.page import render_page
from gaitflow.report.palette import gait_colours
from gaitflow.report.sections import highlights, sections
from gaitflow.report.state_space import draw_state_space
from gaitflow.report.winners import by_size, central, winners
from gaitflow.search.solution import Solution

PAGE = "index.html"
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
    sampling: SamplingRecord | None = None,
) -> list[Path]:
    """Write map.png, gaits.png, state_space.png, a motion-<gait>.png a gait and index.html; return their paths.

    `labels` is the labels frame (`gaitflow.dataset.labels`), `select` the map's decision as an index into `gaits`, from
    the values of each axis with a range, `learning` the data of `Training.as_data()`, `record` the dataset's
    provenance, `sampling` how the tasks were chosen. `select` and `learning` are None when no classifier was trained,
    `record` where no dataset is at hand, `sampling` where the tasks are a grid or nothing is known of it. Raises
    ValueError when `labels` is empty, WriteError when the disk refuses.
    """
    space = scenario.tasks.space
    regions = winners(labels, solutions, space)
    shown = {name: regions[name] for name in by_size(labels)[:MAX_GAITS] if regions[name]}
    colours = gait_colours([*gaits, *regions])
    figures = {"map": draw_gait_map(labels, gaits, select, scenario.description or scenario.name, scenario.tasks)}
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
        highlights(labels, learning, sampling),
        sections(scenario, labels, solutions, regions, learning, record, sampling, images, tuple(motions)),
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
