"""Left-right mirror images of solutions: what a search of one task tells about another, without a solve.

A robot that is its own mirror image moves at the image of a task as it does at the task, with left and right swapped.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.task import AXES, Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.search.solution import Solution
from gaitflow.solvers.point import Multipliers

START = "mirror image"  # of a row that was not searched
POSITION = np.array([1.0, -1.0, 1.0])
BASE = np.concatenate([POSITION, -POSITION] * 2)  # position, yaw, pitch and roll, and their rates: y and pitch differ
SAME = 1e-9  # relative to the largest: numbers that differ by rounding

Places = tuple[NDArray[np.intp], Array]  # for each number where its image is, and its sign there


def has_images(scenario: Scenario) -> bool:
    """Whether the images of a map's tasks are other tasks of the same map.

    So they are of a robot that is its own mirror image, over ranges that are, too. A grid is searched as it is.
    """
    mirrored = [values for axis, values in scenario.tasks.ranges.items() if AXES[axis].mirrored]
    fixed = dict(scenario.tasks.space.fixed)
    straight = all(fixed.get(axis, of.default) == 0 for axis, of in AXES.items() if of.mirrored)
    symmetric = all(values.start == -values.stop for values in mirrored)
    adaptive, robot = scenario.tasks.adaptive is not None, scenario.robot
    return adaptive and bool(robot.mirror) and bool(mirrored) and symmetric and straight


def images_of(tasks: Iterable[Task]) -> list[Task]:
    """The images of tasks that are not their own."""
    return [image for task in tasks if (image := task.mirrored()) != task]


@dataclass(frozen=True)
class MirrorImage:
    """Takes solutions of a scenario to their images."""

    scenario: Scenario

    def scalars(self, one: Solution) -> Solution:
        """The image of a row without its motion; it took no solve."""
        legs, task = self.scenario.robot.mirror_permutation, one.task.mirrored()
        pattern = Pattern.from_text(one.pattern).mirrored(legs)
        gait = gait_of(pattern, self.scenario.symmetry(task)).text
        effort = {"iterations": 0, "solves": 0, "wall_s": 0.0, "cpu_s": 0.0}
        changed = replace(one, task=task, pattern=pattern.text, gait=gait, start=START, **effort)  # type: ignore[arg-type]
        return replace(changed, trajectory=None, multipliers=None)

    def of(self, one: Solution) -> Solution:
        """The image of a row, with that of its motion, if it has one."""
        image = self.scalars(one)
        if one.trajectory is None:
            return image
        image = replace(image, trajectory=self.trajectory(one.trajectory))
        return image if one.multipliers is None else replace(image, multipliers=self.multipliers(one.multipliers))

    def known(self, rows: Iterable[Solution]) -> Iterator[Solution]:
        """What rows tell of their images' tasks, without motions; nothing, where a task is its own image.

        A gait that is its own image costs the same there by the same pattern: the image's is only cut elsewhere.
        """
        for one in rows:
            image = self.scalars(one)
            if image.task == one.task:
                continue
            own = gait_of(Pattern.from_text(one.pattern), self.scenario.symmetry(image.task)).text
            yield replace(image, pattern=one.pattern) if image.gait == own else image

    def trajectory(self, motion: Trajectory) -> Trajectory:
        """The image of a motion in space."""
        legs = list(self.scenario.robot.mirror_permutation)
        of_legs = {
            name: getattr(motion, name)[:, legs] * POSITION
            for name in ("feet", "forces", "end_forces", "foot_velocities")
        }
        return replace(motion, base=motion.base * BASE, **of_legs)

    def multipliers(self, known: Multipliers) -> Multipliers:
        """The image's multipliers: each belongs to the image of its variable or row."""
        (variables, rows), result = self.places, []
        for values, (place, sign) in ((known.bounds, variables), (known.rows, rows)):
            moved = np.empty_like(values)
            moved[place] = sign * values
            result.append(moved)
        return Multipliers(*result)

    @cached_property
    def _problem(self) -> GaitProblem:
        return transcribe(self.scenario)

    @cached_property
    def places(self) -> tuple[Places, Places]:
        """Where the image of each variable and row is, and with which sign: found by their values somewhere."""
        layout, nlp = self._problem.layout, self._problem.nlp
        task = self.scenario.tasks.space.task(
            {
                axis: values.start + 0.37 * (values.stop - values.start)
                for axis, values in self.scenario.tasks.ranges.items()
            }
        )
        w = np.random.default_rng(0).uniform(0.1, 1.0, layout.nw)
        image = layout.pack(self.trajectory(layout.unpack(w, task.cycle_duration)), task.cycle_duration)
        if layout.energy:  # which leg stands when is in w, and in no trajectory
            for leg, partner in enumerate(self.scenario.robot.mirror_permutation):
                image[layout.contacts(leg)] = w[layout.contacts(partner)]
        rows, of_image = (
            np.asarray(nlp(at, each.parameters)[1]).ravel() for at, each in ((w, task), (image, task.mirrored()))
        )
        return _places(w, image), _places(rows, of_image)


def _places(before: Array, after: Array) -> Places:
    """For each value the place of the same number, but for its sign, and that sign.

    Raises ValueError unless both have the same numbers.
    """
    here, there = np.argsort(np.abs(before), kind="stable"), np.argsort(np.abs(after), kind="stable")
    if not np.allclose(np.abs(before)[here], np.abs(after)[there], rtol=0, atol=SAME * np.abs(before).max()):
        raise ValueError("the problem is not its own mirror image, although the robot is")
    place = np.empty(len(before), dtype=np.intp)
    place[here] = there
    return place, np.where(before * after[place] < 0, -1.0, 1.0)
