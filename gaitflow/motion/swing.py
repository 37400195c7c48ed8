"""The curve of a foot in swing: smooth, at rest at lift-off and touchdown."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitflow.core.trajectory import Array
from gaitflow.motion.cycles import Pair

Curve = tuple[Pair, Pair, Pair]  # position [m], velocity [m/s] and acceleration [m/s^2], each [n, 2]


def minimum_jerk(x: Array) -> tuple[Array, Array, Array]:
    """From 0 to 1 as x goes from 0 to 1, with its two derivatives, which vanish at both ends."""
    left = x * (1 - x)
    return x * x * x * (10 + x * (6 * x - 15)), 30 * left * left, 60 * left * (1 - 2 * x)


def swing(lifted: Pair, landed: Pair, duration: Array, x: Array, apex: float) -> Curve:
    """The swing from `lifted` to `landed` [n, 2] m within `duration` [n] s, where a part x [n] of it has passed.

    Over the ground a minimum-jerk line. In height one such piece up, to `apex` m above the higher end at half time, and
    one down: at rest, without acceleration, at both ends and at the top.
    """
    along, pace, gain = minimum_jerk(x)
    way = landed - lifted
    rising = x < 0.5
    low, high = lifted[:, 1].real, landed[:, 1].real
    top = np.maximum(low, high) + apex
    below, climb = np.where(rising, low, top), np.where(rising, top - low, high - top)
    up, lift, push = minimum_jerk(np.where(rising, 2 * x, 2 * x - 1))
    curve = np.empty((3, len(x), 2), dtype=complex)
    curve[:, :, 0] = lifted[:, 0] + way[:, 0] * along, way[:, 0] * pace / duration, way[:, 0] * gain / duration**2
    curve[:, :, 1] = below + climb * up, climb * 2 * lift / duration, climb * 4 * push / duration**2
    return curve[0], curve[1], curve[2]


@dataclass(frozen=True, eq=False)
class PlannedSwing:
    """A swing's own knots in the plan: parts [k] of its duration from 0 to 1, and how far they are off its line [k, 2].

    The line leads from lift-off to touchdown at an even speed. Between knots the foot moves in straight lines.
    """

    parts: Array
    off_line: Pair

    def at(self, lifted: Pair, landed: Pair, duration: Array, x: Array, turn: Pair) -> Curve:
        """The swing as planned, in a cycle that is turned by `turn` [n, 2]; arguments as of `swing`."""
        piece = np.searchsorted(self.parts[1:-1], x, side="right")
        length = (self.parts[piece + 1] - self.parts[piece])[:, None]
        step = self.off_line[piece + 1] - self.off_line[piece]
        off = self.off_line[piece] + step * (x - self.parts[piece])[:, None] / length
        way = landed - lifted
        velocity = (way + turn * step / length) / duration[:, None]
        return lifted + way * x[:, None] + turn * off, velocity, np.zeros_like(way)
