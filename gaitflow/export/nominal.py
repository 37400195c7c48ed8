"""The nominal start as a function of the task that CasADi writes as C: `gaitflow.search.starts.nominal` in symbols."""

from __future__ import annotations

from typing import Any

import casadi
import numpy as np

from gaitflow.core.layout import Layout
from gaitflow.core.task import AXIS_NAMES
from gaitflow.core.trajectory import Array

LEAST_TURN = 1e-8  # rad: below it sin(a) / a is 1


def nominal(layout: Layout, default_feet: Array, task: Any) -> Any:
    """w [nw] of an upright glide along the command over the default feet [legs, d], for a symbolic task [axes]."""
    d, a, (legs, _) = layout.dimension, layout.angles, default_feet.shape
    along = [0] if d == 2 else [0, 1]
    value = dict(zip(AXIS_NAMES, casadi.vertsplit(task), strict=True))
    cycle = value["cycle_duration"]
    times = [share * cycle for share in layout.times(np.full(layout.phases, 1 / layout.phases)).tolist()]
    w, feet = casadi.SX.zeros(layout.nw), list[list[Any]]()
    for knot, time in enumerate(times):
        turned, moved, velocity = _glide(value, time)
        base = casadi.SX.zeros(layout.nb)
        base[d - 1] = -default_feet[:, -1].mean()
        for i in along:
            base[i], base[d + a + i] = moved[i], velocity[i]
        if d == 3:
            base[d], base[layout.nb - 1] = turned, value["yaw_rate"]
        state = layout.state(knot)
        w[state.start : state.start + layout.nb] = base
        feet.append([_foot(foot, turned, moved) for foot in default_feet])
        for leg in range(legs):
            w[layout.foot(knot, leg)] = feet[knot][leg]
    for step in range(layout.steps):
        for leg in range(legs):
            w[layout.force(step, leg).stop - 1] = w[layout.end_force(step, leg).stop - 1] = 1 / legs
            w[layout.foot_velocity(step, leg)] = (feet[step + 1][leg] - feet[step][leg]) / (
                times[step + 1] - times[step]
            )
    w[layout.fractions] = 1 / layout.phases
    return w


def _glide(value: dict[str, Any], time: Any) -> tuple[Any, Any, Any]:
    """How far the command's frame has turned and moved (x, y) at a time, and its velocity; see `core.twist`."""
    turned, v, left = value["yaw_rate"] * time, value["speed"], value["lateral_speed"]
    along, across = _sinc(turned), casadi.sin(turned / 2) * _sinc(turned / 2)
    moved = [time * (v * along - left * across), time * (v * across + left * along)]
    forward = v + value["acceleration"] * (time - value["cycle_duration"] / 2)
    c, s = casadi.cos(turned), casadi.sin(turned)
    return turned, moved, [forward * c - left * s, forward * s + left * c]


def _sinc(angle: Any) -> Any:
    """sin(a) / a."""
    is_still = casadi.fabs(angle) < LEAST_TURN
    return casadi.if_else(is_still, 1.0, casadi.sin(angle) / casadi.if_else(is_still, 1.0, angle))


def _foot(default: Array, turned: Any, moved: Any) -> Any:
    """A default foot [d] carried along on the ground."""
    if len(default) == 2:
        return casadi.vertcat(moved[0] + default[0], 0.0)
    c, s = casadi.cos(turned), casadi.sin(turned)
    x, y = default[:2]
    return casadi.vertcat(moved[0] + c * x - s * y, moved[1] + s * x + c * y, 0.0)
