"""Which feet stand, by the plan and by touch, and where those in the air go."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitflow.clients.reference import Followed, lifted_at
from gaitflow.clients.rotation import turned
from gaitflow.core.trajectory import Array
from gaitflow.motion import State
from gaitflow.motion.swing import minimum_jerk

Contacts = NDArray[np.bool_]

EARLY = 0.5  # share of its swing from which on a foot that touches stands
DESCENT = 0.3  # m/s, of a foot that should stand and does not touch
LOST = 0.02  # s without touch after which a foot that stood is put down again


@dataclass(frozen=True, eq=False)
class FootTargets:
    """Which feet stand [legs], and where the balls of all others should be [legs, 3] m, at which speed [m/s] and
    acceleration [m/s^2]."""

    standing: Contacts
    positions: Array
    velocities: Array
    accelerations: Array


class SwingFeet:
    """The feet of one robot from step to step: when each lifted off and from where, when it touched last."""

    def __init__(self, offsets: Array, motion: Followed, time: float) -> None:
        """offsets [legs, 3] m: from the plan's feet to the balls' centres, in base axes while the robot stands.

        Feet of the motion that are in the air at a time [s] lifted off before it.
        """
        contact = motion.sample([time]).contact[0]
        self._offsets = offsets
        self._planned = contact
        self._standing = contact.copy()
        self._lifted = lifted_at(motion, time, contact)
        self._leaving = np.zeros_like(offsets)  # how far off the plan a foot lifted off
        self._shift = np.zeros_like(offsets)  # of the foothold that comes next
        self._touched = np.full(len(offsets), time)

    def targets(
        self, time: float, state: State, touching: Contacts, centres: Array, shift: Array, yaw: float
    ) -> FootTargets:
        """At a time [s], for balls at centres [legs, 3] m; shift [legs, 3] m moves footholds that are still to come."""
        planned = state.feet + turned(self._offsets, yaw)
        lifting = self._planned & ~state.contact
        self._lifted[lifting] = time
        self._leaving[lifting] = (centres - planned)[lifting]
        self._planned = state.contact.copy()
        self._touched[touching] = time
        swing = np.maximum(time - self._lifted + state.until_touchdown, 1e-3)
        part = np.where(state.contact, 1.0, np.clip((time - self._lifted) / swing, 0.0, 1.0))
        early = ~state.contact & touching & (part > EARLY)
        stays = self._standing & (time - self._touched < LOST)
        self._standing = np.where(state.contact, touching | stays, early | (stays & (part > EARLY)))
        self._shift[~state.contact] = shift[~state.contact]
        eased, pace, gain = minimum_jerk(part)
        rate = np.where(part < 1.0, 1.0 / np.where(np.isfinite(swing), swing, 1.0), 0.0)
        off = self._shift - self._leaving
        late = state.contact & ~self._standing
        positions = planned + self._leaving + eased[:, None] * off
        velocities = state.foot_velocities + (pace * rate)[:, None] * off
        accelerations = state.foot_accelerations + (gain * rate**2)[:, None] * off
        positions[late, 2] = centres[late, 2]
        velocities[late, 2] = -DESCENT
        return FootTargets(self._standing.copy(), positions, velocities, accelerations)
