"""Eq. (2c): phases follow each other, none shorter than a fraction of the cycle, and fill it."""

from __future__ import annotations

import casadi as ca


def fraction_bounds(phases: int, shortest: float) -> tuple[float, float]:
    """Least and largest fraction of the cycle that one phase can take."""
    # Where the shortest phases just fill the cycle, rounding may put the difference below them: 1 - 4 * 0.2 < 0.2.
    return shortest, max(shortest, 1.0 - (phases - 1) * shortest)


def cycle_row(fractions: ca.SX) -> ca.SX:
    """sum of the phase fractions minus 1 [1]; eq. (2c) asks for 0."""
    return ca.sum1(fractions) - 1
