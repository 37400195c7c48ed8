"""What the earlier stages of a run left: that they have run, the map's domain and its atlas."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.domain import Domain
from gaitflow.pipeline.json_file import read_json
from gaitflow.pipeline.workspace import Run

if TYPE_CHECKING:
    import pandas as pd

    from gaitflow.runtime.atlas import Atlas


class StageMissing(RuntimeError):
    """An earlier stage has not run; the message says which command to give."""


def atlas_of(run: Run, scenario: Scenario) -> tuple[Atlas, list[str]]:
    """The atlas of a run, and the names of its gaits."""
    from gaitflow.problem import transcribe
    from gaitflow.runtime.atlas_reader import parse_atlas

    gaits: list[str] = read_json(run.atlas_record)["gaits"]
    problem, content = transcribe(scenario), run.atlas.read_bytes()
    axes = scenario.tasks.space.ranged
    return parse_atlas(content, axes, len(gaits), problem.layout, problem.ng, str(run.atlas)), gaits


def domain_of(run: Run, scenario: Scenario, labels: pd.DataFrame) -> Domain:
    """The grid of a scenario, and which of its tasks have a feasible gait."""
    axes = {axis: values.values for axis, values in scenario.tasks.ranges.items()}
    if scenario.tasks.adaptive is not None:
        return Domain(axes, np.array(read_json(run.atlas_record)["feasible"], dtype=bool))
    solved = labels[(labels["split"] == "grid") & (labels["status"] == "solved")]
    feasible = np.zeros(tuple(map(len, axes.values())), dtype=bool)
    for place in solved[list(axes)].itertuples(index=False, name=None):
        feasible[tuple(values.index(value) for values, value in zip(axes.values(), place, strict=True))] = True
    return Domain(axes, feasible)


def need(path: Path, command: str) -> None:
    """Raises StageMissing, with the command to give, where an earlier stage has not left a file."""
    if not path.exists():
        raise StageMissing(f"{path} is missing: run `{command}` first")
