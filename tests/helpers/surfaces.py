"""Costs of three gaits as functions of the task, to learn a map from."""

from __future__ import annotations

from gaitflow.core.gaits import Pattern, gait_of

PATTERNS = ("0111/1101", "0110/1100", "0001/0100")
WALK, GALLOP, BOUND = (gait_of(Pattern.from_text(text)).text for text in PATTERNS)
GRADIENTS = {WALK: (2.0, 0.0), GALLOP: (1.0, 0.0), BOUND: (0.25, -1.0)}


def cost_surfaces(v: float, t: float) -> dict[str, float]:
    """Walking below 0.8 m/s, gallop above, bounding in the corner of long cycles; infeasible beyond v T = 3.2 m.

    Walking is infeasible above 1.4 m/s, and ties with gallop at 0.8 m/s.
    """
    surfaces = {WALK: 1.0 + 2.0 * v, GALLOP: 1.8 + v, BOUND: 4.9 + 0.25 * v - t}
    if v * t > 3.2:
        return {}
    return {gait: cost for gait, cost in surfaces.items() if gait != WALK or v <= 1.4}
