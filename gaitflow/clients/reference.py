"""States of a motion one at a time, sampled ahead in pieces, because one state takes as long to sample as ten."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gaitflow.core.trajectory import Array
from gaitflow.motion import State

AHEAD = 10  # states a piece


class Followed(Protocol):
    """Whatever can be followed: a `Motion` or a `Journey` with `point="base"` and swings of its own."""

    def sample(self, times: ArrayLike) -> State:
        """The states at times [n] s."""


@dataclass(frozen=True, eq=False)
class Reference:
    """A state to follow, with what a state does not say: how the angular velocity changes [3] rad/s^2, base frame."""

    state: State
    angular_acceleration: Array


class Ahead:
    """The references of a motion at times that are `step` s apart, from a first one on."""

    def __init__(self, motion: Followed, step: float) -> None:
        self._motion, self._step = motion, step
        self._start = 0.0
        self._piece: tuple[State, Array] | None = None

    def at(self, time: float) -> Reference:
        """The reference at a time [s]."""
        place = round((time - self._start) / self._step)
        if self._piece is None or not 0 <= place < AHEAD or abs(self._start + place * self._step - time) > 1e-9:
            self._start, place = time, 0
            states = self._motion.sample(time + self._step * np.arange(AHEAD + 1))
            self._piece = states, np.diff(states.angular_velocity, axis=0) / self._step
        states, gained = self._piece
        return Reference(one_of(states, place), gained[place])


def one_of(states: State, place: int) -> State:
    """The state at a place of states that have a leading axis."""
    return State(**{each.name: getattr(states, each.name)[place] for each in fields(State)})


def lifted_at(motion: Followed, time: float, contact: NDArray[np.bool_], longest: float = 2.0) -> Array:
    """When the legs that swing at a time [s] lifted off [legs] s; at most `longest` s before it."""
    times = time - 0.005 * np.arange(int(longest / 0.005))
    stood = motion.sample(times).contact
    last = np.where(stood.any(axis=0), stood.argmax(axis=0), len(times) - 1)
    lifted: Array = np.where(contact, time, times[last])
    return lifted


def stance_durations(motion: Followed, time: float, ahead: float = 2.0) -> Array:
    """How long the legs stand from a time [s] on, in the mean over about `ahead` s [legs] s."""
    step = 0.005
    contact = motion.sample(time + step * np.arange(int(ahead / step))).contact
    changes = (contact[:-1] != contact[1:]).sum(axis=0)  # two a stance
    mean: Array = 2 * step * contact.sum(axis=0) / np.maximum(changes, 1)
    return mean
