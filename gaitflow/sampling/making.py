"""A map in the making: what is known of it after the tasks that were searched so far."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial

import numpy as np
import pandas as pd

from gaitflow.atlas.border import reconsider
from gaitflow.atlas.compress import build_atlas, cost_atlas
from gaitflow.atlas.fill import fill
from gaitflow.atlas.grow import Growth
from gaitflow.atlas.judge import Predictions, judge_predictions
from gaitflow.atlas.mirror import NodeImages
from gaitflow.atlas.node import Each
from gaitflow.atlas.patterns import full_patterns, map_symmetry, nearly_best
from gaitflow.atlas.plan_solver import PlanSolver
from gaitflow.atlas.reach import reach
from gaitflow.atlas.replant import replant
from gaitflow.atlas.settle import known_costs, settle
from gaitflow.certificate.judge import DEARER, Verdict
from gaitflow.config.scenario import Scenario
from gaitflow.core.domain import Domain
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.dataset.labels import gait_costs, label_tasks
from gaitflow.dataset.mirror import MirrorImage, has_images, images_of
from gaitflow.problem import transcribe
from gaitflow.runtime.atlas import Atlas
from gaitflow.search.solution import Solution

ReadSolutions = Callable[[Sequence[Task]], Iterable[Solution]]  # of searched tasks, with their motions
Tell = Callable[[str], None]


class MapInMaking:
    """The tasks that a map is made from, the gaits that compete at them, and the nodes these have spread to.

    `scalars` and `motions` read the rows of searched tasks: the columns without and the solutions with their motions.
    Where tasks have mirror images in the map (`gaitflow.dataset.mirror`), they read the rows of these as well.
    `each` solves several nodes at once, see `PlanSolver`. Equal tasks, taken in the same order, make equal maps.
    """

    def __init__(
        self,
        scenario: Scenario,
        scalars: Callable[[Sequence[Task]], pd.DataFrame],
        motions: ReadSolutions,
        tell: Tell,
        each: Each | None = None,
    ) -> None:
        self.scenario = scenario
        self.tasks: list[Task] = []
        self._regrets: dict[Task, float] = {}  # of the pick at each task, before it was searched
        self.gaits: list[str] = []  # their keys, since the name of one depends on which others there are
        self.labelled: set[str] = set()
        self.labels, self.costs = pd.DataFrame(), pd.DataFrame()  # of the known tasks, as `gaitflow.dataset.labels`
        self.scalars, self._motions, self.tell = scalars, motions, tell
        self._earlier: Atlas | None = None
        self._numbers: list[int] = []  # the gait of each full pattern of the growth
        self._rows = pd.DataFrame()
        self.problem = transcribe(scenario)
        self._symmetry = map_symmetry(scenario)
        axes = {axis: values.values for axis, values in scenario.tasks.ranges.items()}
        everywhere = Domain(axes, np.ones(tuple(map(len, axes.values())), dtype=bool))
        self.solver = PlanSolver(self.problem, [], each)
        self.growth = Growth(self.problem, self.solver, everywhere, on_node=lambda nodes: tell(f"{nodes} nodes"))
        if has_images(scenario):
            self.growth.images = NodeImages(MirrorImage(scenario), tuple(axes))

    @property
    def domain(self) -> Domain:
        """The tasks that the map answers for: between those of the grid that some gait has spread to."""
        return self.growth.reached

    @property
    def known(self) -> list[Task]:
        """The searched tasks and those of which their mirror images tell."""
        return [*self.tasks, *images_of(self.tasks)] if has_images(self.scenario) else list(self.tasks)

    @property
    def places(self) -> Array:
        """[n, a] where the known tasks are."""
        return np.array([task.on(self.scenario.tasks.ranges) for task in self.known])

    @property
    def regrets(self) -> Array:
        """[n] what the picks at the known tasks had cost too much before they were searched."""
        return np.array([self._regrets.get(task, self._regrets.get(task.mirrored(), 0.0)) for task in self.known])

    def begin_with(self, earlier: Atlas) -> None:
        """Solve the nodes of an earlier map again, each pattern's as soon as it competes, instead of growing them."""
        self._earlier = earlier

    def take(self, tasks: Sequence[Task], verdicts: Sequence[Verdict]) -> None:
        """Make the map from some more searched tasks, too; `verdicts` are of the picks there before."""
        tolerance, legs = self.scenario.learning.tie_tolerance, self.scenario.robot.leg_names
        self._regrets |= {verdict.task: verdict.excess for verdict in verdicts}
        before, self.tasks = self.tasks, [*self.tasks, *tasks]
        self._rows = pd.concat([self._rows, self.scalars(tasks)], ignore_index=True)
        costs = gait_costs(self._rows, legs)
        competing = set(costs.loc[costs["excess"] <= nearly_best(len(self.growth.grid)), "gait_key"])
        self.gaits += sorted(competing - set(self.gaits))
        self.costs = costs
        self.labels = labels = label_tasks(costs, self.known, tolerance, self.scenario.transcription.knots_per_phase)
        keys = dict(zip(costs["gait"], costs["gait_key"], strict=True))
        self.labelled = {keys[name] for name in labels.loc[labels["status"] == "solved", "label"]}
        taken = [pattern.text for pattern in self.growth.solver.patterns]
        names = dict(zip(costs["gait_key"], costs["gait"], strict=True))
        patterns = full_patterns(
            self._rows, costs, [names[key] for key in self.gaits], tolerance, self._symmetry, taken
        )
        new = self._with_images([pattern for pattern in patterns if pattern not in taken])
        self.growth.extend([Pattern.from_text(pattern) for pattern in new])
        self._numbers += [self.gaits.index(self._gait_of(Pattern.from_text(pattern))) for pattern in new]
        if new and self._earlier is not None:
            found = replant(self.growth, self._earlier, new)
            self.tell(f"{found} nodes of the earlier map solved again")
        if new and before:
            self.growth.sow(one for one in self._motions(before) if one.pattern in new)
        self.growth.sow(self._motions(tasks))
        self.tell("gaits spread over the grid")
        self.growth.spread()

    def _gait_of(self, pattern: Pattern) -> str:
        return gait_of(pattern, self._symmetry).text

    def _with_images(self, patterns: Sequence[str]) -> list[str]:
        """Patterns that are new to the growth, and the images of those whose gait is not its own."""
        images, found = self.growth.images, dict.fromkeys(patterns)
        for pattern in map(Pattern.from_text, patterns if images else ()):
            assert images is not None
            image = images.pattern(pattern)
            if self._gait_of(image) != self._gait_of(pattern) and image not in self.growth.solver.patterns:
                found[image.text] = None
        return list(found)

    def fill(self) -> None:
        """Nodes at tasks that no gait reached, where predictions fail or mistake one, and where one was given up."""

        def on_test(done: int, most: int) -> None:
            self.tell(f"test {done} of {most}")

        reach(self.growth)
        with self.inside():
            # With all modes, as no node brings back what a file has no room for.
            fill(self.growth, partial(self.built, sys.maxsize), self.scenario.learning.tie_tolerance, on_test=on_test)
            self.tell("gaits tried again where they were given up")
            reconsider(self.growth)

    def settle(self) -> int:
        """Nodes where the pick is not the search's; at how many known tasks it still is another one."""
        known = known_costs(self.costs, "gait_key", self.gaits, self.scenario.tasks.space.ranged)
        with self.inside():
            return settle(self.growth, self._numbers, known, DEARER, self.tell)

    @property
    def picked(self) -> set[int]:
        """The numbers of the gaits that the map picks from: those that are a label."""
        return {number for number, gait in enumerate(self.gaits) if gait in self.labelled}

    def costs_atlas(self) -> Atlas:
        """The atlas as far as it predicts costs, of all competing gaits."""
        return cost_atlas(self.growth, self._numbers)

    def picking_atlas(self) -> Atlas:
        """The same of the gaits that the map would choose from: those that are a label."""
        return self.costs_atlas().of(sorted(self.picked))

    def built(self, largest: int | None = None) -> Atlas:
        """The whole atlas of the domain, whose gaits are numbers of `gaits`; see `build_atlas`."""
        with self.inside():
            return build_atlas(self.growth, self._numbers, largest)

    def judge_predictions(self, atlas: Atlas) -> Predictions:
        """How good the predictions of the whole atlas, as it was `built`, are inside the domain."""
        with self.inside():
            return judge_predictions(self.growth, atlas)

    def sheets_of(self, gait: int) -> list[int]:
        """The sheets of a gait of that number that have a node."""
        return [sheet for sheet, number in enumerate(self._numbers) if number == gait and self.growth.nodes[sheet]]

    @contextmanager
    def inside(self) -> Iterator[None]:
        """For the length of a block nodes are inside the domain only, not anywhere in the box."""
        everywhere, self.growth.domain = self.growth.domain, self.domain
        yield
        self.growth.domain = everywhere
