"""The path of the centre of mass: the integral of the forces, closed over the cycle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitflow.core.trajectory import Array
from gaitflow.motion.cycles import Cycles, Pair


@dataclass(frozen=True, eq=False)
class Path:
    """A motion whose acceleration runs linearly within each of K steps; pairs [K, 2] at their starts.

    times [K + 1] s, the first 0. Position is a cubic in each step, velocity a quadratic.
    """

    times: Array
    position: Pair
    velocity: Pair
    acceleration: Pair
    jerk: Pair

    def at(self, since: Array) -> tuple[Pair, Pair, Pair]:
        """Position, velocity and acceleration [n, 2] at times [n] s of the cycle."""
        step = np.searchsorted(self.times[1:-1], since, side="right")
        s = (since - self.times[step])[:, None]
        position, velocity, acceleration, jerk = (
            each[step] for each in (self.position, self.velocity, self.acceleration, self.jerk)
        )
        return (
            position + s * (velocity + s / 2 * (acceleration + s / 3 * jerk)),
            velocity + s * (acceleration + s / 2 * jerk),
            acceleration + s * jerk,
        )


def integrated(times: Array, first: Pair, last: Pair, position: Pair, velocity: Pair, cycles: Cycles) -> Path:
    """The path from a position and about a velocity [2] under accelerations from `first` to `last` [K, 2] in each step.

    Velocities and positions are integrals over the whole cycle, so they do not jump at knots, where the stored ones of
    forward Euler would. What such an integral misses of the periodic task is closed by a constant velocity and a
    constant acceleration over the cycle, in a turn by another start as well: with an integrator that is exact they are
    as small as the plan's violation. With Euler's rule the velocity comes to millimetres a second, and the acceleration
    along a straight path to nothing, since that rule is exact in velocity.
    """
    h, period, turn = np.diff(times)[:, None], cycles.period, cycles.turn
    v = _sums(velocity, h * (first + last) / 2)
    p = _sums(position, h * (v[:-1] + h * (first / 3 + last / 6)))
    missing_v = turn * (velocity + cycles.gain) - v[-1]
    missing_p = turn * position + cycles.shift - p[-1]
    # With a more in position, b in velocity and c in acceleration: b + c T = turn b + missing_v and
    # a + b T + c T^2 / 2 = turn a + missing_p; of these the least 4 |a|^2 + |b T|^2, a = 0 along a straight path.
    left = missing_p - missing_v * period / 2
    more_p = np.conj(1 - turn) / 4 * left
    more_v = np.conj(1 + turn) / 2 * left / period
    more_a = (missing_v - (1 - turn) * more_v) / period
    since = times[:-1, None]
    return Path(
        times=times,
        position=p[:-1] + more_p + since * more_v + since**2 / 2 * more_a,
        velocity=v[:-1] + more_v + since * more_a,
        acceleration=first + more_a,
        jerk=(last - first) / h,
    )


def between(times: Array, first: Pair, last: Pair, start: tuple[Pair, Pair], end: tuple[Pair, Pair]) -> Path:
    """The path from one position and velocity [2] each to another one, under accelerations as of `integrated`.

    What the integral misses of the end is closed by an acceleration that runs linearly over the whole time: as small as
    the plan's violation where the integrator is exact.
    """
    h, duration = np.diff(times)[:, None], times[-1]
    v = _sums(start[1], h * (first + last) / 2)
    p = _sums(start[0], h * (v[:-1] + h * (first / 3 + last / 6)))
    missing_p, missing_v = end[0] - p[-1], end[1] - v[-1]
    constant = 6 * missing_p / duration**2 - 2 * missing_v / duration
    rising = 6 * missing_v / duration**2 - 12 * missing_p / duration**3
    since = times[:-1, None]
    return Path(
        times=times,
        position=p[:-1] + since**2 * (constant / 2 + since / 6 * rising),
        velocity=v[:-1] + since * (constant + since / 2 * rising),
        acceleration=first + constant + since * rising,
        jerk=(last - first) / h + rising,
    )


def _sums(start: Pair, steps: Pair) -> Pair:
    return np.concatenate([start[None], start + np.cumsum(steps, axis=0)])
