"""A map in the making: what is known of it after the tasks that were searched so far."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import pandas as pd

from gaitflow.atlas.border import find_borders
from gaitflow.atlas.compress import build_atlas, cost_atlas
from gaitflow.atlas.fill import LIMIT, fill
from gaitflow.atlas.grow import Growth
from gaitflow.atlas.judge import Predictions, judge_predictions
from gaitflow.atlas.mirror import NodeImages
from gaitflow.atlas.node import Each, NodeSolver
from gaitflow.atlas.patterns import full_patterns, map_symmetry, nearly_best
from gaitflow.atlas.settle import known_costs, settle
from gaitflow.certificate.judge import DEARER, Verdict, judge_picks
from gaitflow.config.scenario import Scenario
from gaitflow.core.domain import Domain
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.dataset.labels import gait_costs, label_tasks
from gaitflow.dataset.mirror import MirrorImage, has_images, images_of
from gaitflow.problem import transcribe
from gaitflow.runtime.atlas import SUPPORT, Atlas
from gaitflow.search.attempts import best_of, until_feasible
from gaitflow.search.solution import Solution
from gaitflow.solvers.fixed_gait import FixedGaitSolver

STARTS = 2  # nearest nodes of a pattern from which a pick is solved
HALF_BELIEVED = SUPPORT / 2  # support from which a cheaper gait makes a pick suspicious

ReadSolutions = Callable[[Sequence[Task]], Iterable[Solution]]  # of searched tasks, with their motions
Tell = Callable[[str], None]


@dataclass(frozen=True)
class Suspect:
    """A task whose pick, once planned, may be wrong.

    `gaits` are the numbers of the pick and of gaits of the map that may cost less. infeasible: the pick has no motion.
    missing: another gait, which the map does not pick from, is predicted to cost less.
    """

    task: Task
    gaits: frozenset[int]
    infeasible: bool
    missing: bool


class MapInMaking:
    """The tasks that a map is made from, the gaits that compete at them, and the nodes these have spread to.

    `scalars` and `motions` read the rows of searched tasks: the columns without and the solutions with their motions.
    Where tasks have mirror images in the map (`gaitflow.dataset.mirror`), they read the rows of these as well.
    `each` solves several nodes at once, see `NodeSolver`. Equal tasks, taken in the same order, make equal maps.
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
        self._scalars, self._motions, self.tell = scalars, motions, tell
        self._numbers: list[int] = []  # the gait of each full pattern of the growth
        self._rows, self._costs = pd.DataFrame(), pd.DataFrame()
        self._problem = transcribe(scenario)
        self._symmetry = map_symmetry(scenario)
        axes = {axis: values.values for axis, values in scenario.tasks.ranges.items()}
        everywhere = Domain(axes, np.ones(tuple(map(len, axes.values())), dtype=bool))
        solver = NodeSolver(self._problem, [], each)
        self.growth = Growth(self._problem, solver, everywhere, on_node=lambda nodes: tell(f"{nodes} nodes"))
        if has_images(scenario):
            self.growth.images = NodeImages(MirrorImage(scenario), tuple(axes))
        self._solver = FixedGaitSolver(self._problem, scenario.strategy.solve_time_limit)

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

    def take(self, tasks: Sequence[Task], verdicts: Sequence[Verdict]) -> None:
        """Make the map from some more searched tasks, too; `verdicts` are of the picks there before."""
        tolerance, legs = self.scenario.learning.tie_tolerance, self.scenario.robot.leg_names
        self._regrets |= {verdict.task: verdict.excess for verdict in verdicts}
        before, self.tasks = self.tasks, [*self.tasks, *tasks]
        self._rows = pd.concat([self._rows, self._scalars(tasks)], ignore_index=True)
        costs = gait_costs(self._rows, legs)
        competing = set(costs.loc[costs["excess"] <= nearly_best(len(self.growth.grid)), "gait_key"])
        self.gaits += sorted(competing - set(self.gaits))
        labels = label_tasks(costs, self.known, tolerance, self.scenario.transcription.knots_per_phase)
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
        if new and before:
            self.growth.sow(one for one in self._motions(before) if one.pattern in new)
        self.growth.sow(self._motions(tasks))
        self.tell("gaits spread over the grid")
        self.growth.spread()
        self._costs = costs

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
        """Nodes where predictions fail or mistake a gait."""

        def on_test(done: int, most: int) -> None:
            self.tell(f"test {done} of {most}")

        with self._inside():
            fill(self.growth, self.built, self.scenario.learning.tie_tolerance, on_test=on_test)

    def settle(self) -> int:
        """Nodes where the pick is not the search's; at how many known tasks it still is another one."""
        known = known_costs(self._costs, "gait_key", self.gaits, self.scenario.tasks.space.ranged)
        with self._inside():
            return settle(self.growth, self._numbers, known, DEARER, self.tell)

    def suspects(self, tasks: Sequence[Task]) -> list[Suspect]:
        """Of tasks that were not searched those whose pick may be wrong."""
        atlas, picks, picked = self.costs_atlas(), self._picks(tasks), self.picked
        found = []
        for task, pick, cost in zip(tasks, picks, self._pick_costs(tasks, picks), strict=True):
            costs, support = atlas.costs(np.array(task.on(atlas.axes)))
            cheaper = costs * self._problem.cost_scale * (1 + DEARER) < (np.inf if cost is None else cost)
            rivals = {atlas.sheets[sheet].gait for sheet in np.flatnonzero(cheaper & (support >= HALF_BELIEVED))}
            missing = {atlas.sheets[sheet].gait for sheet in np.flatnonzero(cheaper & (support >= SUPPORT))} - picked
            if cost is None or rivals - {pick}:
                found.append(Suspect(task, frozenset((rivals & picked) | {pick}), cost is None, bool(missing)))
        return found

    def look_closely(self, suspects: Sequence[Suspect]) -> None:
        """Nodes of the suspected gaits at their tasks, or the borders before which their motions end."""
        ranged = self.scenario.tasks.ranges
        gaits = [(gait, one.task.on(ranged)) for one in suspects for gait in sorted(one.gaits)]
        with self._inside():
            find_borders(self.growth, [(sheet, place) for gait, place in gaits for sheet in self._sheets_of(gait)])
            self.growth.spread()

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

    def built(self) -> Atlas:
        """The whole atlas, whose gaits are numbers of `gaits`."""
        return build_atlas(self.growth, self._numbers)

    def judge_predictions(self) -> Predictions:
        """How good the predictions of the whole atlas are inside the domain."""
        with self._inside():
            return judge_predictions(self.growth, self.built())

    def judge(self, tasks: Sequence[Task]) -> list[Verdict]:
        """What the map's picks come to at tasks of its domain that were searched."""
        if not tasks:
            return []
        costs = gait_costs(self._scalars(tasks), self.scenario.robot.leg_names)
        picks = self._picks(tasks)
        names = [self.gaits[pick] if pick >= 0 else "" for pick in picks]
        by_task = dict(zip(tasks, picks, strict=True))
        return judge_picks(list(tasks), names, costs, lambda task: self._pick_costs([task], [by_task[task]])[0])

    def has_motion(self, tasks: Sequence[Task]) -> list[bool]:
        """Whether the map's pick has a motion, at tasks of its domain that were not searched."""
        picks = self._picks(tasks)
        return [cost is not None for cost in self._pick_costs(tasks, picks)]

    def _picks(self, tasks: Sequence[Task]) -> list[int]:
        """The number of the gait that the map picks at each task, -1 where its atlas knows none."""
        kept, atlas, picks = sorted(self.picked), self.picking_atlas(), []
        for task in tasks:
            ranked = atlas.ranked(np.array(task.on(atlas.axes)))
            picks.append(kept[atlas.sheets[ranked[0]].gait] if ranked else -1)
        return picks

    def _pick_costs(self, tasks: Sequence[Task], picks: Sequence[int]) -> list[float | None]:
        """The least cost of a gait at each task, from its nearest nodes, else other starts; None without a motion."""
        places = [task.on(self.scenario.tasks.ranges) for task in tasks]
        sheets = [self._sheets_of(pick) for pick in picks]
        found: dict[tuple[int, int], float] = {}
        for start in range(STARTS):
            asked = [
                (number, sheet)
                for number, each in enumerate(sheets)
                for sheet in each
                if (number, sheet) not in found and start < len(self.growth.nodes[sheet])
            ]
            requests = [
                (sheet, places[number], self.growth.nearest(sheet, places[number], start + 1)[start])
                for number, sheet in asked
            ]
            costs = self.growth.solver.costs_at(requests, LIMIT)
            found |= {
                at: cost * self._problem.cost_scale for at, cost in zip(asked, costs, strict=True) if cost is not None
            }
        return [
            min(known) if (known := [found[number, sheet] for sheet in each if (number, sheet) in found])
            else self._from_other_starts(each, task)
            for number, (task, each) in enumerate(zip(tasks, sheets, strict=True))
        ]  # fmt: skip

    def _sheets_of(self, gait: int) -> list[int]:
        return [sheet for sheet, number in enumerate(self._numbers) if number == gait and self.growth.nodes[sheet]]

    def _from_other_starts(self, sheets: Sequence[int], task: Task) -> float | None:
        restarts, found = self.scenario.strategy.restarts, list[float]()
        for sheet in sheets:
            pattern = self.growth.solver.patterns[sheet]
            best = best_of(until_feasible(self._solver, pattern, task, None, restarts))
            found += [] if best is None else [best.cost]
        return min(found, default=None)

    @contextmanager
    def _inside(self) -> Iterator[None]:
        """For the length of a block nodes are inside the domain only, not anywhere in the box."""
        everywhere, self.growth.domain = self.growth.domain, self.domain
        yield
        self.growth.domain = everywhere
