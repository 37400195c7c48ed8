"""The contact schedule of a motion as plain data: who stands from when to when, and where."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from gaitflow.motion.motion import Motion

DIGITS = 9  # of what is written: nanoseconds, nanometres
SHORTEST = 1e-9  # of a cycle: nearer edges are one


class Interval(NamedTuple):
    """A time from `start` to `end` [s] over which the same feet stand, `contact` [legs]."""

    start: float
    end: float
    contact: tuple[bool, ...]


def intervals(motion: Motion, cycles: int = 1) -> list[Interval]:
    """The contacts of the first `cycles` cycles, one interval after the other, neighbours different.

    Raises ValueError as `Motion.phases`.
    """
    stances = [stance for leg in range(len(motion.leg_names)) for stance in motion.phases(leg, cycles)]
    horizon = cycles * motion.period
    inside = sorted(edge for stance in stances for edge in stance[:2] if 0 < edge < horizon)
    edges = [0.0]
    for edge in [*inside, horizon]:
        if edge - edges[-1] > SHORTEST * motion.period:
            edges.append(edge)
    edges[-1] = horizon
    contacts = motion.sample([(start + end) / 2 for start, end in pairwise(edges)]).contact.tolist()
    found: list[Interval] = []
    for (start, end), contact in zip(pairwise(edges), contacts, strict=True):
        if found and found[-1].contact == tuple(contact):
            found[-1] = found[-1]._replace(end=end)
        else:
            found.append(Interval(start, end, tuple(contact)))
    return found


def schedule_data(motion: Motion, cycles: int = 1) -> dict[str, Any]:
    """The first `cycles` cycles as plain data, lengths in m and times in s, rounded to 9 digits.

    `intervals` have the contact of each leg as 0 or 1, in the order of `legs`; `stances` are by leg those that reach
    into the cycles, None instead of a start or end that does not exist. Raises ValueError as `Motion.phases`.
    """
    return {
        "legs": list(motion.leg_names),
        "cycle_duration": _number(motion.period),
        "cycles": int(cycles),
        "intervals": [
            {
                "start": _number(each.start),
                "end": _number(each.end),
                "contact": [int(stands) for stands in each.contact],
            }
            for each in intervals(motion, cycles)
        ],
        "stances": {
            leg: [
                {"start": _number(start), "end": _number(end), "foothold": [_number(x) for x in foothold.tolist()]}
                for start, end, foothold in motion.phases(leg, cycles)
            ]
            for leg in motion.leg_names
        },
    }


def schedule_json(motion: Motion, cycles: int = 1) -> str:
    """`schedule_data` as JSON text."""
    return json.dumps(schedule_data(motion, cycles), indent=1, allow_nan=False) + "\n"


def _number(value: float) -> float | None:
    return round(float(value), DIGITS) + 0.0 if math.isfinite(value) else None


def written(value: float) -> str:
    """A number for other programs' files: plain digits, at most 9 behind the point."""
    return np.format_float_positional(round(float(value), DIGITS) + 0.0, trim="0")
