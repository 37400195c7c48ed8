"""The start of one phase of a gait: the state there, and the contacts before and after it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array
from gaitflow.motion.motion import Motion
from gaitflow.motion.place import Place


@dataclass(frozen=True, eq=False)
class PhaseStart:
    """The start of a phase, `since` [s] after that of its cycle.

    base [nb] and feet [legs, d]: the plan's own, in the frame that follows the command. contacts [phases, legs] and
    durations [phases] s are those of the phases from this one on; the last ones are those before it.
    """

    since: float
    base: Array
    feet: Array
    contacts: NDArray[np.bool_]
    durations: Array

    @property
    def swinging(self) -> NDArray[np.bool_]:
        """Which legs are in the middle of a swing [legs]."""
        return ~self.contacts[0] & ~self.contacts[-1]


def phase_starts(motion: Motion) -> list[PhaseStart]:
    """Those of a motion's cycle, in order; of one that always stands the first one, which is any time of it."""
    plan = motion.trajectory
    contacts = np.array([[digit == "1" for digit in row] for row in motion.pattern.split("/")]).T
    found = []
    for phase in range(1 if contacts.all() else len(contacts)):
        knot = phase * ((len(plan.times) - 1) // len(contacts))
        since = float(plan.times[knot])
        seen = Place.commanded(motion.task, since).inverse
        found.append(
            PhaseStart(
                since=since,
                base=seen.bodies(plan.base[knot]),
                feet=seen.points(plan.feet[knot]),
                contacts=np.roll(contacts, -phase, axis=0),
                durations=np.roll(plan.durations, -phase),
            )
        )
    return found
