"""A robot's walk as things to draw: its body as a box, its legs as lines through their joints, forces on its feet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array

EDGES = tuple((i, i | 1 << axis) for axis in range(3) for i in range(8) if not i >> axis & 1)


@dataclass(frozen=True, eq=False)
class WalkScene:
    """n moments, 30 a second, in the plan's world: x along the ground, z normal to it; metres.

    times [n] s, middle [n, 3] of the body, body [n, 8, 3] its box's corners, corner i with the bits x, y, z of i; legs
    [n, legs, 4, 3]: three joints and the foot; forces [n, legs, 3] over the robot's weight; ground: its z; height: of
    the standing body above it. touching [m, legs]: which feet touched, every `step` s from time 0. planned [legs]: the
    plan's pattern, its phases `durations` [phases] s long.
    """

    times: Array
    middle: Array
    body: Array
    legs: Array
    forces: Array
    ground: float
    height: float
    leg_names: tuple[str, ...]
    touching: NDArray[np.bool_]
    step: float
    planned: tuple[str, ...]
    durations: Array
