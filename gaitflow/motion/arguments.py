"""What a motion is asked for: times that are finite, legs that there are. Every one raises ValueError."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Integral, Real

import numpy as np

from gaitflow.core.trajectory import Array


def checked_time(time: object, name: str = "time") -> float:
    """A time [s], which the caller calls `name`."""
    if isinstance(time, bool) or not isinstance(time, Real) or not math.isfinite(time):
        raise ValueError(f"{name} = {time!r}: must be a finite number of seconds")
    return float(time)


def checked_span(span: object) -> tuple[float, float]:
    """A span of time: start and stop [s]."""
    if isinstance(span, Sequence) and len(span) == 2:
        start, stop = (checked_time(time, f"span[{place}]") for place, time in enumerate(span))
        if start < stop:
            return start, stop
    raise ValueError(f"span = {span!r}: must be two times (start, stop) in s, the first one before the second")


def checked_times(times: object) -> Array:
    """Times [n] s."""
    asked = np.asarray(times)
    if asked.ndim != 1 or (asked.size and asked.dtype.kind not in "fiu"):
        raise ValueError(f"times: must be a list of numbers, found {asked.dtype} of shape {asked.shape}")
    seconds = asked.astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(seconds))
    if bad.size:
        raise ValueError(f"times[{bad[0]}] = {seconds[bad[0]]}: must be a finite number of seconds")
    return seconds


def checked_apex(apex: object) -> float | None:
    """The height of a swing [m], None for the plan's own feet."""
    if apex is None:
        return None
    if isinstance(apex, bool) or not isinstance(apex, Real) or not 0 < float(apex) < math.inf:
        raise ValueError(f"swing_apex = {apex!r}: must be a height above 0 m, or None for the plan's own feet")
    return float(apex)


def checked_count(cycles: object) -> int:
    """A number of cycles."""
    if isinstance(cycles, bool) or not isinstance(cycles, Integral) or int(cycles) < 1:
        raise ValueError(f"cycles = {cycles!r}: must be a number of cycles, 1 or more")
    return int(cycles)


def leg_number(leg: object, names: Sequence[str]) -> int:
    """The number of a leg that is given by it or by its name."""
    if isinstance(leg, str) and leg in names:
        return names.index(leg)
    if not isinstance(leg, bool) and isinstance(leg, Integral) and 0 <= int(leg) < len(names):
        return int(leg)
    listed = ", ".join(f"{number} {name}" for number, name in enumerate(names))
    raise ValueError(f"leg = {leg!r}: the legs are {listed}")
