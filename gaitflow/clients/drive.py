"""Drive: a robot in MuJoCo follows a changing speed, led by a pilot; records what happened and how long ticks took."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitflow.clients.controller import CONTROL_STEP
from gaitflow.clients.pilot import RATE, Change, Pilot
from gaitflow.clients.robot_model import RobotModel
from gaitflow.clients.walking import FRAMES_PER_SECOND, Frame, Walker
from gaitflow.core.trajectory import Array
from gaitflow.motion import Motion

UP, DOWN = 0.4, 0.6  # parts of a course: until the top speed is reached, and until it is left


@dataclass(frozen=True)
class Course:
    """A commanded speed over `duration` s: from 0 to `top` m/s, held, and back to 0, for which its last 5 s are left.

    What is asked for has noise of a deviation of `noise` m/s, new each tick, by a seed.
    """

    top: float
    duration: float = 60.0
    noise: float = 0.02
    seed: int = 0

    def speed(self, time: float) -> float:
        """Commanded at a time [s], m/s."""
        last = max(self.duration - 5.0, 0.8 * self.duration)
        return float(np.interp(time, [0.0, UP * last, DOWN * last, last], [0.0, self.top, self.top, 0.0]))

    def asked(self) -> Array:
        """What the pilot is told at each tick [n], m/s."""
        times = np.arange(round(self.duration * RATE)) / RATE
        rng = np.random.default_rng(self.seed)
        speeds = np.array([self.speed(each) for each in times])
        return speeds + rng.normal(0.0, self.noise, len(times))


@dataclass(frozen=True, eq=False)
class Drive:
    """A drive: when it fell [s] or None, the pilot's changes, and each tick's select-and-follow [n] and control [n] s.

    times, commanded and speeds [n]: at each tick, m/s; the robot's is the mean over the second around it. touching
    [steps, legs] after each ms, and frames as of `Walk`.
    """

    fell: float | None
    changes: Sequence[Change]
    late: int
    ticks: Array
    control: Array
    times: Array
    commanded: Array
    speeds: Array
    touching: NDArray[np.bool_]
    frames: Sequence[Frame]
    first: Motion

    @property
    def gaits(self) -> list[tuple[float, str | None]]:
        """Since when [s] each gait was followed, from a stand, None, at time 0; where only the speed changes, too."""
        return [(0.0, None), *((change.begins, change.gaits[1]) for change in self.changes if change.found)]

    @property
    def gait_changes(self) -> int:
        """How often a walking robot took another gait."""
        return sum(change.found and None not in change.gaits and len(set(change.gaits)) == 2 for change in self.changes)

    def as_data(self) -> dict[str, Any]:
        """The drive without its frames, as plain data."""
        planning = [change.planning for change in self.changes]
        return {
            "fell": self.fell,
            "gait_changes": self.gait_changes,
            "speed_changes": sum(change.found for change in self.changes) - self.gait_changes,
            "no_transition": sum(not change.found for change in self.changes),
            "late": self.late,
            "tick_ms": _spread(1e3 * self.ticks),
            "control_ms": _spread(1e3 * self.control),
            "planning_s": _spread(np.array(planning or [0.0])),
            "speed_error": float(np.sqrt(np.mean((self.speeds - self.commanded) ** 2))),
            "changes": [asdict(change) for change in self.changes],
        }


def drive(pilot: Pilot, robot: RobotModel, course: Course, each: Callable[[float], None] | None = None) -> Drive:
    """Drive a course in MuJoCo, from a stand; `each` is called after every tick with the time [s].

    Raises ValueError for a map of the plane, and what `Pilot.tick` does.
    """
    walker = Walker(robot, pilot.motion)
    per_tick = round(1 / RATE / CONTROL_STEP)
    ticks, control, places, touching = [], [], [walker.frame.position[0]], []
    frames: list[Frame] = []
    fell = None
    for asked in course.asked():
        planned = len(pilot.changes)
        started = time.perf_counter()
        followed = pilot.tick(walker.time, float(asked))
        taken = time.perf_counter() - started
        ticks.append(taken - sum(change.planning for change in pilot.changes[planned:]))
        if followed is not walker.motion:
            walker.follow(followed)
        started = time.perf_counter()
        for _ in range(per_tick):
            if walker.time * FRAMES_PER_SECOND >= len(frames) - 1e-6:
                frames.append(walker.frame)
            touching += [moment.forces[:, 2] > 0 for moment in walker.advance()]
        control.append((time.perf_counter() - started) / per_tick)
        places.append(walker.frame.position[0])
        if each is not None:
            each(walker.time)
        if walker.fallen:
            fell = walker.time
            break
    times = np.arange(len(ticks)) / RATE
    return Drive(
        fell=fell,
        changes=tuple(pilot.changes),
        late=pilot.late,
        ticks=np.array(ticks),
        control=np.array(control),
        times=times,
        commanded=np.array([course.speed(each) for each in times]),
        speeds=_mean_speeds(np.array(places)),
        touching=np.array(touching),
        frames=tuple(frames),
        first=pilot.first,
    )


def borders(pilot: Pilot, course: Course) -> int:
    """How often the pilot's gait would change along the course itself, without noise and without hysteresis."""
    asked = (course.speed(tick / RATE) for tick in range(round(course.duration * RATE)))
    gaits = [
        pilot.answer(min(max(each, pilot.slowest), pilot.fastest)).gait for each in asked if each >= pilot.slowest / 2
    ]
    return sum(one != other for one, other in pairwise(gaits))


def _mean_speeds(places: Array) -> Array:
    """Speeds [n] m/s by places [n + 1] m at each tick, over the second around each."""
    half = round(RATE / 2)
    n = len(places) - 1
    first, last = np.maximum(np.arange(n) - half, 0), np.minimum(np.arange(n) + half, n)
    return np.asarray((places[last] - places[first]) / ((last - first) / RATE))


def _spread(values: Array) -> dict[str, float]:
    return {"median": float(np.median(values)), "p99": float(np.quantile(values, 0.99)), "max": float(values.max())}
