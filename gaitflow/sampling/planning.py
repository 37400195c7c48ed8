"""What a map in the making plans: the motions of `gaitflow.runtime.plan`, for many tasks side by side.

A plan's solves follow from each other, so each task has a generator that asks for the next one. What the generators at
work ask for is solved together, in several processes.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import partial
from itertools import islice

import numpy as np

from gaitflow.atlas.node import Place
from gaitflow.atlas.plan_solver import Try
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.attempt import Effort
from gaitflow.runtime.plan import TOP
from gaitflow.runtime.refine import tries_of
from gaitflow.runtime.rivals import LEAST_SAVING, effort_for, likely, tried_below, unlikely
from gaitflow.runtime.starts import starts_of
from gaitflow.sampling.making import MapInMaking
from gaitflow.search import starts
from gaitflow.search.attempts import best_of, until_feasible
from gaitflow.solvers.fixed_gait import FixedGaitSolver

Asked = tuple[Try, int]  # with the iterations that it may take
Solves = Generator[Asked, float | None, "Planned | None"]  # asks for solves, hears their costs, ends with the plan
Solved = Generator[Asked, float | None, float | None]  # asks for the solves of one sheet, ends with its cost
Nominal = Callable[[Place], Array]  # the nominal start w [nw] at a place
Chances = Callable[[Array], Array]  # at places [n, axes] the probability of each gait of the map to be the best [n, G]

AT_ONCE = 256  # tasks at work: enough for many processes, and few enough that some end soon and progress moves


@dataclass(frozen=True)
class Planned:
    """The gait of a plan, by its number in the map in the making, and the plan's cost, unscaled."""

    gait: int
    cost: float


class Planning:
    """Plans of a map in the making as it is now, from the atlas that would be published, `making.built()`.

    `chances` are those of the classifier that would be, whose columns are `making.gaits`.
    """

    def __init__(self, making: MapInMaking, atlas: Atlas, chances: Chances) -> None:
        self._making, self._chances = making, chances
        self._gaits = sorted(making.picked)
        self._atlas = atlas.of(self._gaits)
        self._sheets = making.growth.numbers_of(self._atlas)
        self._solver = FixedGaitSolver(making.problem, making.scenario.strategy.solve_time_limit)

    def plans(self, tasks: Sequence[Task]) -> list[Planned | None]:
        """The plan at each task, None where no gait has a motion."""
        places = [task.on(self._atlas.axes) for task in tasks]
        asked = [
            solves(self._atlas, place, self._sheets, self._nominal, chances)
            for place, chances in zip(places, self._chances_at(places), strict=True)
        ]

        def on_plans(done: int) -> None:
            self._making.tell(f"plan {done} of {len(tasks)}")

        found = together(asked, self._making.solver.costs_from, on_plans)
        scale = self._making.problem.cost_scale
        return [
            self._from_other_starts(task) if plan is None else Planned(self._gaits[plan.gait], plan.cost * scale)
            for task, plan in zip(tasks, found, strict=True)
        ]

    def picks(self, tasks: Sequence[Task]) -> list[int]:
        """The number of the gait that `select` would name at each task, -1 where the atlas knows none."""
        places = [task.on(self._atlas.axes) for task in tasks]
        ranked = [
            self._atlas.ranked(np.array(place), chances)
            for place, chances in zip(places, self._chances_at(places), strict=True)
        ]
        return [self._gaits[self._atlas.sheets[sheets[0]].gait] if sheets else -1 for sheets in ranked]

    def _chances_at(self, places: Sequence[Place]) -> list[list[float]]:
        """The probabilities of the atlas' gaits at each place."""
        if not places:
            return []
        found: list[list[float]] = self._chances(np.array(places))[:, self._gaits].tolist()
        return found

    def _nominal(self, place: Place) -> Array:
        scenario, layout = self._making.scenario, self._making.problem.layout
        task = scenario.tasks.space.task(dict(zip(self._atlas.axes, place, strict=True)))
        return starts.nominal(scenario.robot, layout, task)

    def _from_other_starts(self, task: Task) -> Planned | None:
        """The first gait that has a motion from other starts than the map's, as a plan's last resort."""
        place, patterns = task.on(self._atlas.axes), self._making.growth.solver.patterns
        [chances] = self._chances_at([place])
        for sheet in self._atlas.ranked(np.array(place), chances)[:TOP]:
            pattern, restarts = patterns[self._sheets[sheet]], self._making.scenario.strategy.restarts
            best = best_of(until_feasible(self._solver, pattern, task, None, restarts))
            if best is not None:
                return Planned(self._gaits[self._atlas.sheets[sheet].gait], best.cost)
        return None


def solves(atlas: Atlas, place: Place, patterns: Sequence[int], nominal: Nominal, chances: Sequence[float]) -> Solves:
    """The solves of a plan at a place: `refine_ranked` without its last resort. Costs are the problem's.

    `patterns` are the numbers by which the atlas' sheets are solved; `chances` the probabilities of its gaits.
    """
    asked = np.array(place)
    solved = partial(_solved, atlas, asked, patterns, nominal)
    candidates = atlas.by_cost(asked, chances)
    gaits = list(dict.fromkeys(atlas.sheets[sheet].gait for sheet in candidates))[:TOP]
    tried = set[int]()
    for sheet in (sheet for sheet in candidates if atlas.sheets[sheet].gait in gaits):
        tried.add(sheet)
        cost = yield from solved(sheet, Effort.FIRST)
        if cost is not None:
            of_gaits = dict(enumerate(chances))
            tried_anyway, spared = likely(atlas, of_gaits), unlikely(atlas, of_gaits)
            firsts = [each for each in atlas.ranked(asked, chances) if atlas.sheets[each].gait in tried_anyway]
            sure = {each: chances[atlas.sheets[each].gait] for each in firsts}
            spared -= {atlas.sheets[candidates[0]].gait}
            done = tried.union(each for each in candidates if atlas.sheets[each].gait in spared)
            return (yield from _cheapest(atlas, (sheet, cost), done, sure, asked, solved))
    return None


def _cheapest(
    atlas: Atlas,
    first: tuple[int, float],
    done: Set[int],
    sure: Mapping[int, float],
    asked: Array,
    solved: Callable[[int, Effort], Solved],
) -> Generator[Asked, float | None, Planned]:
    """The plan that was found first, of this sheet and cost, or a cheaper one.

    Sheets are tried that may be cheaper, or are of `sure`, with their probabilities.
    """
    (sheet, cost), least = first, atlas.least_costs(asked)
    best, share = Planned(atlas.sheets[sheet].gait, cost), tried_below(atlas, least[sheet], cost)
    for rival in np.argsort(least, kind="stable").tolist():
        if rival not in done and (rival in sure or least[rival] < best.cost * share):
            found = yield from solved(rival, effort_for(least[rival], best.cost, sure.get(rival, 0.0)))
            if found is not None and found < best.cost * (1 - LEAST_SAVING):
                best = Planned(atlas.sheets[rival].gait, found)
    return best


def _solved(
    atlas: Atlas, asked: Array, patterns: Sequence[int], nominal: Nominal, sheet: int, effort: Effort
) -> Solved:
    """The cost of the motion that one of a sheet's starts leads to, as `tries_of` says."""
    place, (most, limit) = tuple(asked.tolist()), tries_of(atlas, effort)
    for start in islice(starts_of(atlas, sheet, asked, partial(nominal, place)), most):
        cost = yield (patterns[sheet], place, start), limit
        if cost is not None:
            return cost
    return None


def together(
    asked: Iterable[Solves],
    solve: Callable[[Sequence[Try], int], Sequence[float | None]],
    on_plans: Callable[[int], None] = lambda done: None,
) -> list[Planned | None]:
    """What generators end with, `AT_ONCE` of them at work; `solve` is given their requests, those of one limit at once.

    `on_plans` hears how many have ended, each time that all others at work ask for another solve.
    """
    generators = list(asked)
    found: list[Planned | None] = [None] * len(generators)
    waiting, ended = iter(range(len(generators))), 0
    answers: dict[int, float | None] = dict.fromkeys(islice(waiting, AT_ONCE))
    while answers:
        requests: dict[int, dict[int, Try]] = {}
        for number, answer in answers.items():
            try:
                request, limit = generators[number].send(answer)
                requests.setdefault(limit, {})[number] = request
            except StopIteration as end:
                found[number] = end.value
                ended += 1
        on_plans(ended)
        answers = {}
        for limit, each in requests.items():
            answers |= zip(each, solve(list(each.values()), limit), strict=True)
        answers |= dict.fromkeys(islice(waiting, AT_ONCE - len(answers)))
    return found
