"""warmstarts.safetensors: for each gait the mean motion of its region, and the bounds that impose its pattern.

Bounds are kept by their levels (`gaitflow.runtime.levels`), all else is float64.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np
from safetensors.numpy import save

from gaitflow.core.layout import Layout
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.runtime.levels import LEVELS, levelled, levels_of, read_bounds
from gaitflow.runtime.tensor_file import TensorFile
from gaitflow.solvers.point import GaitSpace

MAX_ROWS = 10_000_000
BOUNDS = ("lower_bounds", "upper_bounds", "lower_rows", "upper_rows")


@dataclass(frozen=True, eq=False)
class GaitTensors:
    """float64 tensors over G gaits in the manifest's order, nw variables and ng rows, in the problem's scaling.

    primal, multipliers_bounds, lower_bounds, upper_bounds [G, nw]; multipliers_rows, lower_rows, upper_rows [G, ng].
    Bounds may be infinite, all else is finite. Multipliers have CasADi's signs.
    """

    primal: Array
    multipliers_bounds: Array
    multipliers_rows: Array
    lower_bounds: Array
    upper_bounds: Array
    lower_rows: Array
    upper_rows: Array

    @property
    def rows(self) -> int:
        """Number of rows ng of the map's problem."""
        return int(self.multipliers_rows.shape[1])

    def space(self, gait: int) -> GaitSpace:
        """The bounds of gait number `gait`."""
        return GaitSpace(self.lower_bounds[gait], self.upper_bounds[gait], self.lower_rows[gait], self.upper_rows[gait])

    def mean(self, gait: int) -> tuple[Array, Array, Array]:
        """The mean of the gait's region: primal [nw], multipliers of bounds [nw] and rows [ng]."""
        return self.primal[gait], self.multipliers_bounds[gait], self.multipliers_rows[gait]


@dataclass(frozen=True)
class WarmStart(Trajectory):
    """Where to start an optimiser of `pattern`: a trajectory in SI units, and the map's own scaled vectors.

    task: the values on the map's axes that it is for; of a region's mean only the cycle_duration. primal [nw] is the
    decision vector, multipliers_bounds [nw] and multipliers_rows [ng] are those of the map's problem (CasADi's
    signs). Predicted for the task, or the mean over a region of tasks: near feasible, not feasible.
    """

    gait: str
    pattern: str
    task: Mapping[str, float]
    primal: Array
    multipliers_bounds: Array
    multipliers_rows: Array


def tensor_bytes(tensors: GaitTensors) -> bytes:
    """The file's content. Equal tensors give equal bytes."""
    arrays = {name: np.ascontiguousarray(value, dtype=np.float64) for name, value in asdict(tensors).items()}
    levels = levels_of(arrays[name] for name in BOUNDS)
    levelled_bounds = {name: levelled(arrays[name], levels) for name in BOUNDS}
    return save(arrays | levelled_bounds | ({} if levels is None else {LEVELS: levels}))


def parse_tensors(content: bytes, gaits: int, layout: Layout, where: str, scaled: bool = False) -> GaitTensors:
    """The tensors in a file's bytes, checked for names, types, shapes and values. Raises ArtifactError.

    `scaled`: there is a `scale` [nw] as well, as in formats 1 and 2, which has to be the layout's.
    """
    file = TensorFile.parse(content, where)
    names = set(GaitTensors.__annotations__)
    file.expect(names | ({"scale"} if scaled else set()) | {LEVELS} & set(file.tensors))
    shape = np.shape(file.tensors["multipliers_rows"])
    rows = shape[1] if len(shape) == 2 else 0
    if not 1 <= rows <= MAX_ROWS:
        file.refuse("multipliers_rows", f"has the shape {shape}; expected {gaits} gaits by 1 to {MAX_ROWS} rows")
    found = {}
    for name in sorted(names):
        size = rows if name.endswith("_rows") else layout.nw
        shape = (gaits, size)
        found[name] = read_bounds(file, name, shape) if name in BOUNDS else file.array(name, shape, np.float64)
    for kind in ("bounds", "rows"):
        if (found[f"lower_{kind}"] > found[f"upper_{kind}"]).any():
            file.refuse(f"lower_{kind}", f"has a value above its upper_{kind}")
    if scaled and not np.allclose(file.array("scale", (layout.nw,), np.float64), layout.scale(1.0), rtol=1e-9, atol=0):
        file.refuse("scale", "is not what the scenario's robot gives")
    return GaitTensors(**found)


def warm_start(
    layout: Layout, gait: str, pattern: str, vectors: tuple[Array, Array, Array], task: Mapping[str, float]
) -> WarmStart:
    """The warm start in vectors (primal [nw], multipliers of bounds [nw] and rows [ng]) for a task's values."""
    primal, bounds, rows = vectors
    return WarmStart(
        **vars(layout.unpack(primal, task["cycle_duration"])),
        gait=gait,
        pattern=pattern,
        task=task,
        primal=primal,
        multipliers_bounds=bounds,
        multipliers_rows=rows,
    )
