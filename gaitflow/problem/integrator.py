"""One step of the explicit integrators a scenario may name; the paper uses forward Euler (section III.B)."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca

Rate = Callable[[ca.SX], ca.SX]


def step(name: str, rate: Rate, x: ca.SX, h: ca.SX) -> ca.SX:
    """x after h seconds with the control held: `euler`, x + h f(x), or `rk4`, the classical Runge-Kutta step."""
    if name == "euler":
        return x + h * rate(x)
    k1 = rate(x)
    k2 = rate(x + h / 2 * k1)
    k3 = rate(x + h / 2 * k2)
    k4 = rate(x + h * k3)
    return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
