"""What an artifact is made of, and the bytes and the manifest that follow from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import datetime
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from safetensors.numpy import save

from gaitflow.config.scenario import digest_of
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.trajectory import Array
from gaitflow.problem import GaitProblem
from gaitflow.runtime.atlas import Atlas, atlas_bytes
from gaitflow.runtime.files import ATLAS, CLASSIFIER, PROBLEM, WARM_STARTS, entry_of
from gaitflow.runtime.layout import Layout
from gaitflow.runtime.manifest import FORMAT, TIME_FORMAT
from gaitflow.runtime.versions import Version


class PublishError(RuntimeError):
    """Parts that make no sound artifact: names each fault. Nothing was published."""


class RegionStart(Protocol):
    """Where the solver of one gait starts, in the scaled variables of its fixed-gait problem.

    gait is its name, pattern its full pattern as text; primal [nw], and the multipliers of the bounds [nw] and of the
    rows [ng] with CasADi's signs.
    """

    @property
    def gait(self) -> str: ...  # noqa: D102
    @property
    def pattern(self) -> str: ...  # noqa: D102
    @property
    def primal(self) -> Array: ...  # noqa: D102
    @property
    def bounds(self) -> Array: ...  # noqa: D102
    @property
    def rows(self) -> Array: ...  # noqa: D102


@dataclass(frozen=True)
class Parts:
    """All that is published.

    problem knows the scenario. feasible [speeds, cycle durations] says which grid tasks have a feasible gait.
    classifier is the ONNX graph (float32 [N, 2] -> `probability` [N, G]), classes [G] the gait of each of its outputs,
    starts hold one start for each of them, in any order. atlas has sheets whose gaits are numbers of classes. dataset
    names what was learnt from (`digest`, `version`), code what made it; metrics, plain JSON, say how well.
    solver_options are IPOPT's, over the defaults of a warm-started refinement. Raises PublishError when a class and a
    start do not pair up.
    """

    problem: GaitProblem
    feasible: NDArray[np.bool_]
    classifier: bytes
    classifier_kind: str
    classes: Sequence[str]
    starts: Sequence[RegionStart]
    atlas: Atlas
    dataset: Mapping[str, Any]
    code: Mapping[str, Any]
    metrics: Mapping[str, Any]
    solver_options: Mapping[str, float | int | str]

    def __post_init__(self) -> None:
        names = sorted(start.gait for start in self.starts)
        if names != sorted(set(self.classes)) or len(names) != len(self.classes):
            raise PublishError(f"the classifier's gaits are {list(self.classes)}, but there are starts for {names}")
        if strangers := {sheet.gait for sheet in self.atlas.sheets} - set(range(len(self.classes))):
            raise PublishError(f"{len(self.classes)} gaits, but the atlas has sheets of {sorted(strangers)}")

    @property
    def ordered_starts(self) -> list[RegionStart]:
        """The starts [G] in the order of the classifier's outputs."""
        by_name = {start.gait: start for start in self.starts}
        return [by_name[name] for name in self.classes]


def content_of(parts: Parts) -> dict[str, bytes]:
    """The bytes of every file but the card and the manifest. Equal parts give equal bytes."""
    return {
        CLASSIFIER: parts.classifier,
        PROBLEM: parts.problem.nlp.serialize().encode("ascii"),
        WARM_STARTS: save(_tensors(parts)),
        ATLAS: atlas_bytes(parts.atlas),
    }


def manifest_of(parts: Parts, files: Mapping[str, bytes], version: Version, created: datetime) -> dict[str, Any]:
    """The manifest as plain data; `files` is every file but itself."""
    scenario = parts.problem.scenario
    data = scenario.as_data()
    mirror = scenario.robot.mirror_permutation
    return {
        "format": FORMAT,
        "version": str(version),
        "created": created.strftime(TIME_FORMAT),
        "scenario": data,
        "scenario_digest": digest_of(data),
        "dataset": dict(parts.dataset),
        "code": dict(parts.code),
        "domain": {
            "speed": list(scenario.tasks.speed.values),
            "cycle_duration": list(scenario.tasks.cycle_duration.values),
            "feasible": np.asarray(parts.feasible, dtype=bool).tolist(),
        },
        "gaits": [
            {
                "name": start.gait,
                "key": gait_of(Pattern.from_text(start.pattern), mirror).text,
                "pattern": start.pattern,
            }
            for start in parts.ordered_starts
        ],
        "layout": layout_data(parts.problem),
        "cost_scale": parts.problem.cost_scale,
        "classifier": {"kind": parts.classifier_kind},
        "metrics": dict(parts.metrics),
        "solver": {"options": dict(parts.solver_options)},
        "files": {name: asdict(entry_of(content)) for name, content in sorted(files.items())},
    }


def runtime_layout(problem: GaitProblem) -> Layout:
    """The sizes of the problem's decision vector."""
    theirs = problem.layout
    return Layout(
        phases=theirs.phases,
        knots_per_phase=theirs.knots_per_phase,
        legs=problem.scenario.robot.leg_names,
        dimension=theirs.dimension,
        base=theirs.nb,
        rows=problem.ng,
    )


def layout_data(problem: GaitProblem) -> dict[str, Any]:
    """The sizes of the problem's decision vector as the runtime reads them."""
    layout = runtime_layout(problem)
    return {
        **asdict(layout),
        "legs": list(layout.legs),
        "variables": layout.variables,
        "duration_slice": list(layout.duration_slice),
    }


def _tensors(parts: Parts) -> dict[str, Array]:
    """The tensors of `gaitflow.runtime.tensors.GaitTensors` by name."""
    starts = parts.ordered_starts
    bounds = [parts.problem.bounds(Pattern.from_text(start.pattern)) for start in starts]
    stacks = {
        "primal": [start.primal for start in starts],
        "multipliers_bounds": [start.bounds for start in starts],
        "multipliers_rows": [start.rows for start in starts],
        "lower_bounds": [one.lower for one in bounds],
        "upper_bounds": [one.upper for one in bounds],
        "lower_rows": [one.lower_rows for one in bounds],
        "upper_rows": [one.upper_rows for one in bounds],
    }
    # At a cycle of 1 s the durations' scale is 1: they stay fractions of the cycle.
    scale = parts.problem.layout.scale(1.0)
    return {name: np.array(rows, dtype=np.float64) for name, rows in stacks.items()} | {"scale": scale}
