"""A motion plan as arrays: the one shape that solvers, datasets, maps and planners share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Trajectory:
    """A motion plan pi(t), eq. (1), on K+1 knots; SI units, terrain frame, ground at z = 0.

    times [K+1] s; base [K+1, nb]: position d, angles a, velocity d, angular velocity a, so nb = 6 in the plane and
    12 in space; feet [K+1, legs, d] m; forces, end_forces [K, legs, d] N; foot_velocities [K, legs, d] m/s;
    durations [phases] s. In step k, from knot k to k+1, a foot moves at its foot velocity and its force runs linearly
    from forces[k] to end_forces[k]; held forces have the two equal. Between phases a force may jump.
    """

    times: Array
    base: Array
    feet: Array
    forces: Array
    end_forces: Array
    foot_velocities: Array
    durations: Array
