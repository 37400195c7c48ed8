"""A start for TOWR: durations of phases, initial stances and both ends of the base, as C++ statements."""

from __future__ import annotations

import numpy as np

from gaitflow.core.trajectory import Array
from gaitflow.motion.contact_schedule import Span, horizon, written
from gaitflow.motion.journey import Journey
from gaitflow.motion.motion import Motion
from gaitflow.motion.stances import SHORTLY, within


def towr_formulation(motion: Motion | Journey, cycles: int = 1, span: Span | None = None) -> str:
    """What sets a `towr::NlpFormulation formulation` for the first `cycles` cycles or a span, to be included in C++.

    End effectors are in the order of the motion's legs; TOWR's quadrupeds have LF, RF, LH, RH. TOWR's time begins at
    the span's start. Durations alternate between stance and swing and add up to the horizon. Of a leg that swings at
    the start, initial_ee_W_ is in the air. Raises ValueError for a robot in the plane, a journey without a span, and as
    `Motion.phases`.
    """
    if motion.dimension != 3:
        raise ValueError("dimension = 2: TOWR's robots are in space")
    start, stop = horizon(motion, cycles, span)
    lines = []
    for number, leg in enumerate(motion.leg_names):
        durations, stands = _durations(motion, leg, (start, stop))
        lines += [
            f"// {leg}",
            f"formulation.params_.ee_phase_durations_.push_back({{{', '.join(map(written, durations))}}});",
            f"formulation.params_.ee_in_contact_at_start_.push_back({'true' if stands else 'false'});",
            f"formulation.initial_ee_W_.push_back(Eigen::Vector3d({_vector(motion.at(start).feet[number])}));",
        ]
    for name, time in (("initial", start), ("final", stop)):
        state = motion.at(time)
        lines += [
            f"formulation.{name}_base_.lin.at(towr::kPos) << {_vector(state.position)};",
            f"formulation.{name}_base_.lin.at(towr::kVel) << {_vector(state.velocity)};",
        ]
    return "\n".join(lines) + "\n"


def _durations(motion: Motion | Journey, leg: str, span: Span) -> tuple[list[float], bool]:
    """How long a leg stands, swings, stands, ... [s], and whether it stands first."""
    (start, stop), stances = span, within(motion.phases(leg, span=span), *span)
    edges = [edge for stance in stances for edge in stance[:2] if start + SHORTLY < edge < stop - SHORTLY]
    stands = bool(stances) and stances[0].start <= start + SHORTLY
    return np.diff([start, *edges, stop]).tolist(), stands


def _vector(vector: Array) -> str:
    return ", ".join(written(value) for value in vector.tolist())
