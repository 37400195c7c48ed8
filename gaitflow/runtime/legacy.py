"""Maps of formats 1 and 2, from when a task was a speed and a cycle duration and the problem was stored as code.

They load and select as today's do. Their problem is a serialised CasADi function. The C++ code that reads one trusts
its input: whoever writes such a file can crash the process or run code in it. So it is read only to plan, and only for
callers who say that they trust it. Format 1 has no atlas.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version as package_version
from pathlib import Path
from typing import Any

import numpy as np

from gaitflow.core.domain import Domain
from gaitflow.core.errors import ArtifactError
from gaitflow.core.layout import Layout
from gaitflow.core.task import AXIS_NAMES
from gaitflow.core.task_space import MAIN_AXES, TaskSpace
from gaitflow.runtime.files import ATLAS, CARD, CLASSIFIER, PROBLEM, WARM_STARTS, read_checked
from gaitflow.runtime.manifest import SELF_DIGEST, Manifest
from gaitflow.runtime.manifest_fields import (
    MAX_AXIS,
    created,
    feasible,
    file_entries,
    gaits,
    scenario,
    solver_options,
    version,
)
from gaitflow.runtime.strict import Fields

_FIELDS = (
    "format", "version", "scenario", "scenario_digest", "created", "dataset", "code", "domain", "gaits", "layout",
    "cost_scale", "classifier", "metrics", "solver", "files", SELF_DIGEST,
)  # fmt: skip
_CONTENT = {1: (CARD, CLASSIFIER, PROBLEM, WARM_STARTS), 2: (CARD, CLASSIFIER, PROBLEM, WARM_STARTS, ATLAS)}
_LAYOUT = ("phases", "knots_per_phase", "legs", "dimension", "base", "variables", "rows", "duration_slice")


def manifest(data: Mapping[str, Any], where: str) -> Manifest:
    """The manifest in the JSON data of format 1 or 2. Raises ArtifactError."""
    fields = Fields(data, where, _FIELDS)
    content = _CONTENT[fields.integer("format", 1, 2)]
    checked = scenario(fields)
    if TaskSpace.of(checked).ranged != MAIN_AXES:
        fields.refuse("scenario", f"one with the axes {', '.join(MAIN_AXES)}")
    layout = Layout.of(checked)
    _layout(fields.inner("layout", _LAYOUT), layout)
    return Manifest(
        format=fields.integer("format", 1, 2),
        version=version(fields),
        scenario=checked,
        scenario_digest=fields.digest("scenario_digest"),
        created=created(fields),
        dataset=fields.mapping("dataset"),
        code=fields.mapping("code"),
        domain=_domain(fields.inner("domain", (*MAIN_AXES, "feasible"))),
        gaits=gaits(fields, layout),
        cost_scale=fields.positive("cost_scale"),
        classifier_kind=fields.inner("classifier", ("kind",)).text("kind"),
        metrics=fields.mapping("metrics"),
        solver_options=solver_options(fields),
        files=file_entries(fields.inner("files", content), content),
    )


def stored_problem(folder: Path, described: Manifest, rows: int, trust_code: bool) -> Any:
    """The problem of the map in `folder` as (w [nw], task [axes]) -> (cost [1], rows), the task being today's.

    Raises ArtifactError for code that is not trusted, and for what is no such function; ImportError without CasADi.
    """
    path = folder / PROBLEM
    if not trust_code:
        raise ArtifactError(
            f"{path}: a map of format {described.format} holds its problem as code, which runs in this process: "
            "if you trust who made it, load it with GaitMap.load(path, trust_code=True), or publish the map again; "
            "selecting needs no code"
        )
    import casadi

    content = read_checked(folder, PROBLEM, described.files[PROBLEM])
    try:
        function = casadi.Function.deserialize(content.decode("ascii"))
        takes = [function.size_in(i) for i in range(function.n_in())]
        gives = [function.size_out(i) for i in range(function.n_out())]
    except (RuntimeError, ValueError) as error:
        reason = str(error).strip().splitlines()[-1][:200]
        raise ArtifactError(
            f"{path}: CasADi {package_version('casadi')} cannot read it ({reason}); install the version that made it, "
            "which `code` in manifest.json names"
        ) from None
    nw = described.layout.nw
    if takes != [(nw, 1), (len(MAIN_AXES), 1)] or gives != [(1, 1), (rows, 1)]:
        raise ArtifactError(
            f"{path}: the problem maps {takes} to {gives}; expected w [{nw}] and {', '.join(MAIN_AXES)} to cost [1] "
            f"and rows [{rows}]"
        )
    w, task = casadi.SX.sym("w", nw), casadi.SX.sym("task", len(AXIS_NAMES))
    cost, groups = function(w, casadi.vertcat(*(task[AXIS_NAMES.index(axis)] for axis in MAIN_AXES)))
    return casadi.Function("nlp", [w, task], [cost, groups], ["w", "task"], ["cost", "rows"])


def _domain(fields: Fields) -> Domain:
    values = {axis: fields.rising(axis, MAX_AXIS) for axis in MAIN_AXES}
    return Domain(values, np.array(feasible(fields, tuple(map(len, values.values())))))


def _layout(fields: Fields, layout: Layout) -> None:
    """Refuse sizes other than those that the scenario gives."""
    sizes = {
        "phases": layout.phases, "knots_per_phase": layout.knots_per_phase, "dimension": layout.dimension,
        "base": layout.nb, "variables": layout.nw,
    }  # fmt: skip
    for name, size in sizes.items():
        fields.integer(name, size, size)
    if len(fields.items("legs", 8)) != layout.legs:
        fields.refuse("legs", f"{layout.legs} names")
