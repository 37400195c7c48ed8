"""What a map is published from, and the bytes and the manifest that follow from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gaitflow.atlas.patterns import map_symmetry
from gaitflow.config.scenario import digest_of
from gaitflow.config.tasks import grid_of
from gaitflow.core.domain import Domain
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.trajectory import Array
from gaitflow.problem import GaitProblem
from gaitflow.publishing.versioned_folder import PublishError, listed
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.atlas_file import atlas_bytes
from gaitflow.runtime.files import ATLAS, CLASSIFIER, PROBLEM_CHECK, WARM_STARTS
from gaitflow.runtime.manifest import FORMAT, TIME_FORMAT
from gaitflow.runtime.problem_check import POINTS, problem_check_bytes, record
from gaitflow.runtime.tensors import GaitTensors, tensor_bytes
from gaitflow.runtime.versions import Version

MOVED = 0.01  # in the problem's scaled variables


class RegionStart(Protocol):
    """Where the solver of one gait starts, in the scaled variables of its fixed-gait problem.

    gait is its name, pattern its pattern as text; primal [nw], and the multipliers of the bounds [nw] and of the
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

    problem knows the scenario. feasible, a dimension an axis with a range, says which grid tasks have a feasible gait.
    classifier is the ONNX graph (float32 [N, axes] -> `probability` [N, G]), classes [G] the gait of each of its
    outputs, starts hold one start for each of them, in any order. atlas has sheets whose gaits are numbers of classes.
    dataset names what was learnt from (`name`, `version`), code what made it; metrics, plain JSON, say how well.
    solver_options are IPOPT's, over the defaults of a warm-started refinement. Raises PublishError when a class and a
    start do not pair up, or a sheet is of no class.
    """

    problem: GaitProblem
    feasible: NDArray[np.bool_]
    classifier: bytes
    classifier_kind: str
    classes: Sequence[str]
    starts: Sequence[RegionStart]
    atlas: Atlas
    dataset: Mapping[str, str]
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

    @property
    def domain(self) -> Domain:
        """The tasks that the map answers for."""
        ranges = self.problem.scenario.tasks.ranges
        return Domain({axis: values.values for axis, values in ranges.items()}, np.asarray(self.feasible, dtype=bool))


def content_of(parts: Parts) -> dict[str, bytes]:
    """The bytes of every file but the card and the manifest. Equal parts give equal bytes."""
    return {
        CLASSIFIER: parts.classifier,
        WARM_STARTS: tensor_bytes(_tensors(parts)),
        ATLAS: atlas_bytes(parts.atlas),
        PROBLEM_CHECK: _problem_check(parts),
    }


def manifest_of(parts: Parts, files: Mapping[str, bytes], version: Version, created: datetime) -> dict[str, Any]:
    """The manifest as plain data; `files` is every file but itself."""
    scenario = parts.problem.scenario
    data, domain = scenario.as_data(), parts.domain
    return {
        "format": FORMAT,
        "version": str(version),
        "created": created.strftime(TIME_FORMAT),
        "scenario": data,
        "scenario_digest": digest_of(data),
        "dataset": dict(parts.dataset),
        "code": dict(parts.code),
        "domain": {
            "axes": {axis: list(values) for axis, values in domain.axes.items()},
            "feasible": domain.feasible.tolist(),
        },
        "gaits": [
            {"name": start.gait, "key": gait_key(parts.problem, start.pattern), "pattern": start.pattern}
            for start in parts.ordered_starts
        ],
        "cost_scale": parts.problem.cost_scale,
        "classifier": {"kind": parts.classifier_kind},
        "metrics": dict(parts.metrics),
        "solver": {"options": dict(parts.solver_options)},
        "files": listed(files),
    }


def gait_key(problem: GaitProblem, pattern: str) -> str:
    """The canonical text of the gait that a pattern realises in a map."""
    return gait_of(Pattern.from_text(pattern), map_symmetry(problem.scenario)).text


def _tensors(parts: Parts) -> GaitTensors:
    starts = parts.ordered_starts
    bounds = [parts.problem.bounds(Pattern.from_text(start.pattern)) for start in starts]
    return GaitTensors(
        primal=np.array([start.primal for start in starts]),
        multipliers_bounds=np.array([start.bounds for start in starts]),
        multipliers_rows=np.array([start.rows for start in starts]),
        lower_bounds=np.array([one.lower for one in bounds]),
        upper_bounds=np.array([one.upper for one in bounds]),
        lower_rows=np.array([one.lower_rows for one in bounds]),
        upper_rows=np.array([one.upper_rows for one in bounds]),
    )


def _problem_check(parts: Parts) -> bytes:
    """The problem's values beside starts, moved a little so that no term is 0 there, at tasks from end to end."""
    starts, tasks = parts.ordered_starts, grid_of(parts.problem.scenario)
    rng = np.random.default_rng(0)
    points = [starts[n * len(starts) // POINTS].primal for n in range(POINTS)]
    moved = [point + MOVED * rng.uniform(-1.0, 1.0, len(point)) for point in points]
    asked = [tasks[n * (len(tasks) - 1) // (POINTS - 1)] for n in range(POINTS)]
    return problem_check_bytes(record(parts.problem.nlp, moved, asked))
