"""The contact schedule of a motion as plain data: who stands from when to when, and where."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from gaitflow.motion.arguments import checked_count, checked_span
from gaitflow.motion.journey import Journey
from gaitflow.motion.motion import Motion
from gaitflow.motion.stances import SHORTLY

DIGITS = 9  # of what is written: nanoseconds, nanometres

Span = tuple[float, float]  # start and stop [s]


class Interval(NamedTuple):
    """A time from `start` to `end` [s] over which the same feet stand, `contact` [legs]."""

    start: float
    end: float
    contact: tuple[bool, ...]


def horizon(motion: Motion | Journey, cycles: int, span: Span | None) -> Span:
    """From when to when [s]: the first `cycles` cycles of a motion, or a span of a motion or a journey.

    Raises ValueError as `Motion.phases`, and for a journey without a span.
    """
    if span is not None:
        return checked_span(span)
    if isinstance(motion, Journey):
        raise ValueError("a journey has no cycles: say by span=(start, stop) which part of it, in s")
    return 0.0, checked_count(cycles) * motion.period


def intervals(motion: Motion | Journey, cycles: int = 1, span: Span | None = None) -> list[Interval]:
    """The contacts of the first `cycles` cycles, or of a span, one interval after the other, neighbours different.

    Raises ValueError as `horizon`.
    """
    start, stop = horizon(motion, cycles, span)
    stances = [stance for leg in range(len(motion.leg_names)) for stance in motion.phases(leg, span=(start, stop))]
    inside = sorted(edge for stance in stances for edge in stance[:2] if start < edge < stop)
    edges = [start]
    for edge in [*inside, stop]:
        if edge - edges[-1] > SHORTLY:
            edges.append(edge)
    edges[-1] = stop
    contacts = motion.sample([(start + end) / 2 for start, end in pairwise(edges)]).contact.tolist()
    found: list[Interval] = []
    for (start, end), contact in zip(pairwise(edges), contacts, strict=True):
        if found and found[-1].contact == tuple(contact):
            found[-1] = found[-1]._replace(end=end)
        else:
            found.append(Interval(start, end, tuple(contact)))
    return found


def schedule_data(motion: Motion | Journey, cycles: int = 1, span: Span | None = None) -> dict[str, Any]:
    """The first `cycles` cycles, or a span, as plain data, lengths in m and times in s, rounded to 9 digits.

    `intervals` have the contact of each leg as 0 or 1, in the order of `legs`; `stances` are by leg those that reach
    into the cycles or the span, None instead of a start or end that does not exist. `cycle_duration` and `cycles`, or
    `span`, say what was asked for. Raises ValueError as `horizon`.
    """
    start, stop = horizon(motion, cycles, span)
    if isinstance(motion, Motion) and span is None:
        asked: dict[str, Any] = {"cycle_duration": _number(motion.period), "cycles": int(cycles)}
    else:
        asked = {"span": [_number(start), _number(stop)]}
    return {
        "legs": list(motion.leg_names),
        **asked,
        "intervals": [
            {
                "start": _number(each.start),
                "end": _number(each.end),
                "contact": [int(stands) for stands in each.contact],
            }
            for each in intervals(motion, span=(start, stop))
        ],
        "stances": {
            leg: [
                {"start": _number(begin), "end": _number(end), "foothold": [_number(x) for x in foothold.tolist()]}
                for begin, end, foothold in motion.phases(leg, span=(start, stop))
            ]
            for leg in motion.leg_names
        },
    }


def schedule_json(motion: Motion | Journey, cycles: int = 1, span: Span | None = None) -> str:
    """`schedule_data` as JSON text."""
    return json.dumps(schedule_data(motion, cycles, span), indent=1, allow_nan=False) + "\n"


def _number(value: float) -> float | None:
    return round(float(value), DIGITS) + 0.0 if math.isfinite(value) else None


def written(value: float) -> str:
    """A number for other programs' files: plain digits, at most 9 behind the point."""
    return np.format_float_positional(round(float(value), DIGITS) + 0.0, trim="0")
