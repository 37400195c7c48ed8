"""warmstarts.safetensors: for each gait the mean motion of its region, and the bounds that impose its pattern."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from safetensors import SafetensorError
from safetensors.numpy import load

from gaitflow.core.errors import ArtifactError
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.runtime.layout import Layout, unpack
from gaitflow.solvers.point import GaitSpace


@dataclass(frozen=True)
class GaitTensors:
    """float64 tensors over G gaits in the manifest's order, nw variables and ng rows, in the problem's scaling.

    primal, multipliers_bounds, lower_bounds, upper_bounds [G, nw]; multipliers_rows, lower_rows, upper_rows [G, ng];
    scale [nw]: w * scale is in SI units, but for the durations, which stay fractions of the cycle duration.
    Bounds may be infinite, all else is finite. Multipliers have CasADi's signs.
    """

    primal: Array
    multipliers_bounds: Array
    multipliers_rows: Array
    lower_bounds: Array
    upper_bounds: Array
    lower_rows: Array
    upper_rows: Array
    scale: Array

    def space(self, gait: int) -> GaitSpace:
        """The bounds of gait number `gait`."""
        return GaitSpace(self.lower_bounds[gait], self.upper_bounds[gait], self.lower_rows[gait], self.upper_rows[gait])

    def mean(self, gait: int) -> tuple[Array, Array, Array]:
        """The mean of the gait's region: primal [nw], multipliers of bounds [nw] and rows [ng]."""
        return self.primal[gait], self.multipliers_bounds[gait], self.multipliers_rows[gait]


@dataclass(frozen=True)
class WarmStart(Trajectory):
    """Where to start an optimiser of `pattern`: a trajectory in SI units, and the artifact's own scaled vectors.

    primal [nw] is the decision vector, multipliers_bounds [nw] and multipliers_rows [ng] are those of the artifact's
    problem (CasADi's signs). Predicted for the task, or the mean over a region of tasks: near feasible, not feasible.
    """

    gait: str
    pattern: str
    primal: Array
    multipliers_bounds: Array
    multipliers_rows: Array


def shapes(gaits: int, layout: Layout) -> dict[str, tuple[int, ...]]:
    """The shape of each tensor by name."""
    nw, ng = layout.variables, layout.rows
    return {
        "primal": (gaits, nw), "multipliers_bounds": (gaits, nw), "multipliers_rows": (gaits, ng),
        "lower_bounds": (gaits, nw), "upper_bounds": (gaits, nw),
        "lower_rows": (gaits, ng), "upper_rows": (gaits, ng), "scale": (nw,),
    }  # fmt: skip


def parse_tensors(content: bytes, gaits: int, layout: Layout, where: str) -> GaitTensors:
    """The tensors in a file's bytes, checked for names, types, shapes and values. Raises ArtifactError."""
    try:
        tensors = load(content)
    except (SafetensorError, KeyError, ValueError) as error:  # KeyError: an element type numpy does not have
        raise ArtifactError(f"{where}: not a safetensors file ({str(error)[:200]}); copy the artifact again") from None
    expected = shapes(gaits, layout)
    if set(tensors) != set(expected):
        raise ArtifactError(f"{where}: tensors {sorted(tensors)}; expected {sorted(expected)}")
    for name, shape in expected.items():
        tensor = tensors[name]
        if tensor.dtype != np.float64 or tensor.shape != shape:
            raise ArtifactError(f"{where}: {name} is {tensor.dtype} {tensor.shape}; expected float64 {shape}")
        bound = name.startswith(("lower", "upper"))
        if np.isnan(tensor).any() if bound else not np.isfinite(tensor).all():
            raise ArtifactError(f"{where}: {name} holds a value that is not {'a number' if bound else 'finite'}")
    for kind in ("bounds", "rows"):
        if (tensors[f"lower_{kind}"] > tensors[f"upper_{kind}"]).any():
            raise ArtifactError(f"{where}: a value of lower_{kind} lies above its upper_{kind}")
    if (tensors["scale"] <= 0).any():
        raise ArtifactError(f"{where}: scale must be positive")
    for tensor in tensors.values():
        tensor.flags.writeable = False
    return GaitTensors(**tensors)


def warm_start(
    layout: Layout,
    scale: Array,
    gait: str,
    pattern: str,
    vectors: tuple[Array, Array, Array],
    cycle_duration: float,
) -> WarmStart:
    """The warm start in vectors (primal [nw], multipliers of bounds [nw] and rows [ng]) for a cycle duration [s]."""
    primal, bounds, rows = vectors
    return WarmStart(
        **vars(unpack(layout, scale, primal, cycle_duration)),
        gait=gait,
        pattern=pattern,
        primal=primal,
        multipliers_bounds=bounds,
        multipliers_rows=rows,
    )
