"""Atlases whose costs and coordinates are known functions of the task."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from gaitflow.core.layout import Layout
from gaitflow.runtime.atlas import Atlas, Sheet
from gaitflow.solvers.point import GaitSpace

AXES = ("speed", "slope")
STEPS = np.array([0.2, 0.1])
LAYOUT = Layout(dimension=2, legs=2, phases=2, knots_per_phase=1, weight=100.0)
ROWS = 3

Value = Callable[[float, float], float]
Gradient = Callable[[float, float], Sequence[float]]
Values = tuple[Value, Gradient]


def space() -> GaitSpace:
    """All variables free, most of them bounded on one side; an equality, an inequality and a free row."""
    n = LAYOUT.nw
    lower = np.where(np.arange(n) % 3, -1.0, -np.inf)
    upper = np.where(np.arange(n) % 2, 1.0, np.inf)
    return GaitSpace(lower, upper, np.array([0.0, -1.0, -np.inf]), np.array([0.0, 1.0, np.inf]))


def grid(size: int = 5) -> list[tuple[int, int]]:
    """Places in steps."""
    return [(i, j) for i in range(size) for j in range(size)]


def sheet(
    tasks: np.ndarray,
    costs: np.ndarray,
    slopes: np.ndarray,
    coordinates: np.ndarray | None = None,
    tangents: np.ndarray | None = None,
    gait: int = 0,
    modes: int = 2,
) -> Sheet:
    """Random modes, orthogonal; coordinates 0 where none are given."""
    n, a = tasks.shape
    rng, bounds = np.random.default_rng(gait), space()
    basis = np.linalg.qr(rng.normal(size=(bounds.size, modes)))[0].T
    coordinates = np.zeros((n, modes)) if coordinates is None else coordinates
    tangents = np.zeros((n, a, modes)) if tangents is None else tangents
    return Sheet(
        gait=gait,
        pattern="01/10",
        space=bounds,
        tasks=tasks.astype(float),
        costs=costs.astype(float),
        slopes=slopes.astype(float),
        mean=rng.normal(size=bounds.size).astype(np.float32),
        modes=basis.astype(np.float32),
        coordinates=coordinates.astype(np.float32),
        tangents=tangents.astype(np.float32),
        tear=50.0,
        infeasible=np.zeros((0, a)),
    )


def sheet_of(value: Value, gradient: Gradient, places: Sequence[tuple[int, int]] | None = None, gait: int = 0) -> Sheet:
    """A sheet whose cost's logarithm and whose first coordinate are `value` of the place in steps."""
    nodes = grid() if places is None else places
    tasks = np.array(nodes) * STEPS
    logs = np.array([value(x, y) for x, y in nodes])
    slopes = np.array([gradient(x, y) for x, y in nodes]) / STEPS
    coordinates = np.column_stack([logs, np.zeros(len(nodes))])
    tangents = np.stack([slopes, np.zeros_like(slopes)], axis=-1)
    return sheet(tasks, np.exp(logs), slopes, coordinates, tangents, gait)


def atlas(*sheets: Sheet) -> Atlas:
    return Atlas(AXES, STEPS, 1e-4, sheets)
