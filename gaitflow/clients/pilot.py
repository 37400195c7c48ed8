"""A pilot: it asks a map 50 times a second for gait and cycle duration, and changes the motion when they change."""

from __future__ import annotations

import math
import time
from collections import deque
from dataclasses import dataclass
from statistics import median
from typing import Any

from gaitflow.core.errors import NoTransition
from gaitflow.core.layout import GRAVITY
from gaitflow.motion import Journey, Motion, standing
from gaitflow.runtime import Choice, GaitMap, Plan

RATE = 50.0  # Hz
SMOOTHING = 0.5  # s: the median of what was asked for in this time counts
STEP = 0.05  # m/s: how far the asked speed gets from the followed one before the motion is changed
KEPT = 0.01  # relative cost for which a gait is kept; the command is smooth already
LONGEST = 3.0  # cycle, over the time in which a robot on two feet falls e times farther
LEAD = 1.0  # s from the decision to the earliest start of a transition, in which it is planned


@dataclass(frozen=True)
class Change:
    """A change of motion: when it was decided and when it begins and is over [s], between which gaits and speeds [m/s].

    A robot that stands has no gait, None. planning [s] is how long plan and transition took; `found` is False where
    there was none and the robot went on as before.
    """

    decided: float
    begins: float
    settled: float
    gaits: tuple[str | None, str | None]
    speeds: tuple[float, float]
    planning: float
    found: bool


class Pilot:
    """Steers along a map by speed alone, from a stand; `tick` it at RATE with the time and the speed asked for.

    What is asked for may be noisy, and counts as its median over SMOOTHING.
    The cycle duration is the map's choice, with its hysteresis, or the longest with which a trot's two feet can balance
    the robot, if that is shorter. A speed below half the map's slowest asks for a stand, and it takes the slowest one
    to leave that. A transition counts as planned while the motion goes on for LEAD; one that takes longer is `late`.
    Raises what `GaitMap.plan` does, and NoTransition where the robot cannot set off.
    """

    def __init__(self, gait_map: GaitMap) -> None:
        self._map = gait_map
        speeds = gait_map.manifest.domain.axes["speed"]
        self.slowest, self.fastest = float(speeds[0]), float(speeds[-1])
        height = max(-leg["default_foot"][-1] for leg in gait_map.manifest.scenario["robot"]["legs"])
        self._longest = LONGEST * math.sqrt(height / GRAVITY)
        self._asked: deque[float] = deque(maxlen=round(SMOOTHING * RATE))  # m/s, the last ones
        self._choice: Choice | None = None  # the last answer
        self._followed: Choice | None = None  # the one whose motion is followed, None at a stand
        self.first = self._planned(self.answer(self.slowest))
        self.motion: Motion | Journey = standing(self.first)
        self._map.switch(self.motion, self.first)  # the problem of transitions is built on first use, for seconds
        self.changes: list[Change] = []
        self._again = 0.0  # when [s] to look for a change after one was not found

    @property
    def late(self) -> int:
        """How many transitions took longer to plan than the lead that they had."""
        return sum(change.planning > LEAD for change in self.changes)

    def tick(self, now: float, asked: float) -> Motion | Journey:
        """What to follow from a time [s] on, when a speed [m/s] is asked for."""
        self._asked.append(asked)
        wanted = self._wanted(median(self._asked))
        if now >= max(self._settled, self._again) and self._differs(wanted):
            self._change(now, wanted)
        return self.motion

    def _wanted(self, asked: float) -> Choice | None:
        """The map's answer, None where it is to stand."""
        if asked < self.slowest / (1 if self._followed is None else 2):
            return None
        speed = min(max(asked, self.slowest), self.fastest)
        self._choice = self.answer(speed, self._choice)
        return self._choice

    def answer(self, speed: float, previous: Choice | None = None) -> Choice:
        """The map's gait and cycle duration at a speed [m/s] of its domain; it keeps those of `previous` if it can."""
        choice = self._map.select(speed=speed, previous=previous, margin=KEPT)
        if choice.cycle_duration <= self._longest:
            return choice
        return self._map.select(speed=speed, cycle_duration=self._longest, previous=previous, margin=KEPT)

    @property
    def _settled(self) -> float:
        return self.motion.settled if isinstance(self.motion, Journey) else 0.0

    def _differs(self, wanted: Choice | None) -> bool:
        followed = self._followed
        if wanted is None or followed is None:
            return wanted is not followed
        return wanted.gait != followed.gait or abs(wanted.speed - followed.speed) >= STEP

    def _change(self, now: float, wanted: Choice | None) -> None:
        started = time.perf_counter()
        found = True
        try:
            other = standing(self.first) if wanted is None else self._planned(wanted)
            self.motion = self._map.switch(self.motion, other, after=now + LEAD)
        except NoTransition:
            found, self._again = False, now + LEAD
        before = self._followed
        if found:
            self._followed = wanted
        begins = self.motion.transition.start if isinstance(self.motion, Journey) else now
        self.changes.append(
            Change(
                decided=now,
                begins=begins,
                settled=self._settled,
                gaits=(_gait(before), _gait(wanted)),
                speeds=(_speed(before), _speed(wanted)),
                planning=time.perf_counter() - started,
                found=found,
            )
        )

    def _planned(self, choice: Choice) -> Motion:
        task: dict[str, Any] = dict(choice.task)
        plan: Plan = self._map.plan(gait=choice.gait, **task)
        if not plan.feasible:
            raise NoTransition(f"no feasible motion of {choice.gait} at {dict(choice.task)}")
        return plan.motion(point="base")


def _gait(choice: Choice | None) -> str | None:
    return None if choice is None else choice.gait


def _speed(choice: Choice | None) -> float:
    return 0.0 if choice is None else choice.speed
