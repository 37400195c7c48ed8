"""In which order a plan tries gaits, by which method, and which one it takes, with a refiner whose solves are scripted.

Its solves end as a test tells, so that each case is reached; tests/runtime/test_plan.py makes real plans.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from tiny_map import task_of

from gaitflow.core.task import Task
from gaitflow.core.trajectory import Trajectory
from gaitflow.runtime import GaitMap
from gaitflow.runtime.atlas import NEAR_AXES, Atlas
from gaitflow.runtime.attempt import Attempt, Candidate, Effort
from gaitflow.runtime.plan import Asked, refine_ranked
from gaitflow.runtime.rivals import EVEN, FEW_AXES, LIKELY, LIKELY_FEW, LIKELY_WIDE, UNLIKELY

TASK, VALUES = task_of(0.9, 0.6), {"speed": 0.9, "cycle_duration": 0.6}


@pytest.fixture(scope="module")
def gait_map(pristine: Path) -> GaitMap:
    return GaitMap.load(pristine)


class Scripted:
    """A refiner whose solves end as told: (violation, solver status) by candidate, of the fast method and of IPOPT.

    A candidate's number is its sheet, or its gait where it has none.
    """

    def __init__(
        self,
        gait_map: GaitMap,
        fast: list[tuple[float, str]],
        fallback: list[tuple[float, str]],
        least: tuple[float, ...] = (np.inf, np.inf),
        costs: tuple[float, ...] = (10.0, 11.0),
        axes: int = 2,
    ) -> None:
        start = gait_map.select(0.9, 0.6).warm_start
        self._fields = {field.name: getattr(start, field.name) for field in dataclasses.fields(Trajectory)}
        self._ends = {"fast": fast, "fallback": fallback}
        self._least, self._costs = least, costs
        self.atlas = Atlas.empty([f"axis {n}" for n in range(axes)])
        self.calls: list[tuple[str, int]] = []

    @staticmethod
    def _number(candidate: Candidate) -> int:
        return candidate.gait if candidate.sheet is None else candidate.sheet

    def _end(self, method: str, candidate: Candidate) -> Attempt:
        number = self._number(candidate)
        self.calls.append((method, number))
        method = "fast" if method.startswith("look") else method
        violation, status = self._ends[method][number]
        trajectory, cost = Trajectory(**self._fields), self._costs[number]
        return Attempt(trajectory, "0110/1100", cost, violation, 7, status, method, 0.5, 1.5)

    def fast(self, candidate: Candidate, task: Task, effort: Effort = Effort.FIRST) -> Attempt:
        return self._end({Effort.RIVAL: "look", Effort.PROMISING: "look hard", Effort.FIRST: "fast"}[effort], candidate)

    def least(self, candidates: Sequence[Candidate], task: Task) -> list[float]:
        return [self._least[self._number(each)] for each in candidates]

    def fallback(self, candidate: Candidate, task: Task) -> Attempt:
        return self._end("fallback", candidate)


GOOD, LIMIT = "Solve_Succeeded", "Maximum_Iterations_Exceeded"
SOLVED, WRONG, EARLY, LOST = (0.0, GOOD), (1e-3, GOOD), (1e-9, LIMIT), (np.inf, LIMIT)
FAST_0, FAST_1, SLOW_0, SLOW_1 = ("fast", 0), ("fast", 1), ("fallback", 0), ("fallback", 1)


@pytest.mark.parametrize(
    ("fast", "fallback", "gait", "path", "feasible", "outcomes"),
    [
        ([SOLVED, SOLVED], [LOST, LOST], "walking", "fast", True, ["solved, fast"]),
        # A success is not believed when the check disagrees, and feasible is not enough without a minimum.
        ([WRONG, LOST], [SOLVED, LOST], "walking", "fallback", True, ["solved, fallback"]),
        ([EARLY, LOST], [SOLVED, LOST], "walking", "fallback", True, ["solved, fallback"]),
        ([LOST, SOLVED], [SOLVED, SOLVED], "gallop", "next:1", True, ["infeasible", "solved, fast"]),
        ([LOST, SOLVED], [WRONG, LOST], "gallop", "next:1", True, ["infeasible", "solved, fast"]),
        ([LOST, LOST], [LOST, SOLVED], "gallop", "next:1", True, ["infeasible", "solved, fallback"]),
        # The motion that breaks the constraints least is handed back when nothing refines.
        ([EARLY, WRONG], [WRONG, LOST], "walking", "failed", True, ["infeasible", "infeasible"]),
        ([LOST, LOST], [LOST, WRONG], "gallop", "failed", False, ["infeasible: violation inf", "infeasible"]),
    ],
)
def test_both_the_check_and_the_solver_must_agree(
    gait_map: GaitMap, fast: list, fallback: list, gait: str, path: str, feasible: bool, outcomes: list
) -> None:
    ranked = [(Candidate(n, None), each, 0.5 - 0.1 * n) for n, each in enumerate(gait_map.gaits)]
    scripted = Scripted(gait_map, fast, fallback)
    plan = refine_ranked(scripted, ranked, Asked(TASK, VALUES, True, 0.25, 0.0))
    assert (plan.gait, plan.path, plan.feasible) == (gait, path, feasible)
    said = [name for name, _ in plan.tried]
    assert said == ["walking", "gallop"][: len(said)]
    assert all(told.startswith(outcome) for (_, told), outcome in zip(plan.tried, outcomes, strict=False))
    assert len(plan.tried) >= len(outcomes)
    assert plan.iterations == 7 * len(scripted.calls)
    assert plan.predict_ms == 0.5 * len(scripted.calls)
    assert plan.cost == (10.0 if gait == "walking" else 11.0)
    assert plan.probability == (0.5 if gait == "walking" else 0.4)
    assert (plan.in_domain, plan.distance) == (True, 0.25)


@pytest.mark.parametrize(
    ("fast", "fallback", "calls"),
    [
        ([LOST, SOLVED], [SOLVED, SOLVED], [FAST_0, FAST_1]),
        ([LOST, LOST], [SOLVED, SOLVED], [FAST_0, FAST_1, SLOW_0]),
        ([LOST, LOST], [LOST, LOST], [FAST_0, FAST_1, SLOW_0, SLOW_1]),
    ],
)
def test_ipopt_is_asked_only_when_no_gait_can_be_had_fast(
    gait_map: GaitMap, fast: list, fallback: list, calls: list[tuple[str, int]]
) -> None:
    ranked = [(Candidate(n, None), each, 0.5) for n, each in enumerate(gait_map.gaits)]
    scripted = Scripted(gait_map, fast, fallback)
    refine_ranked(scripted, ranked, Asked(TASK, VALUES, True, 0.0, 0.0))
    assert scripted.calls == calls


LOOK_1 = ("look", 1)


@pytest.mark.parametrize(
    ("ends", "least", "costs", "gait", "path", "calls"),
    [
        # The other gait is looked at only when it promises to be cheaper than the first one came out, ...
        ([SOLVED, SOLVED], 10.5, (10.0, 11.0), "walking", "fast", [FAST_0]),
        ([SOLVED, SOLVED], 9.995, (10.0, 11.0), "walking", "fast", [FAST_0]),
        ([SOLVED, SOLVED], 9.9, (10.0, 9.8), "gallop", "cheaper:1", [FAST_0, LOOK_1]),
        # ... and taken only when it keeps that promise, and is a motion.
        ([SOLVED, SOLVED], 9.9, (10.0, 10.1), "walking", "fast", [FAST_0, LOOK_1]),
        ([SOLVED, WRONG], 9.9, (10.0, 9.8), "walking", "fast", [FAST_0, LOOK_1]),
        # The next gait is the last one here: none is left to look at.
        ([LOST, SOLVED], 9.9, (10.0, 11.0), "gallop", "next:1", [FAST_0, FAST_1]),
    ],
)
def test_another_gait_is_looked_at_where_it_may_be_cheaper(
    gait_map: GaitMap, ends: list, least: float, costs: tuple, gait: str, path: str, calls: list[tuple[str, int]]
) -> None:
    ranked = [(Candidate(n, None), each, 0.5) for n, each in enumerate(gait_map.gaits)]
    scripted = Scripted(gait_map, ends, [LOST, LOST], (np.inf, least), costs)
    plan = refine_ranked(scripted, ranked, Asked(TASK, VALUES, True, 0.0, 0.0))
    assert (plan.gait, plan.path, plan.feasible) == (gait, path, True)
    assert scripted.calls == calls
    assert plan.cost == costs[0 if gait == "walking" else 1]


@pytest.mark.parametrize(
    ("least", "costs", "gait", "path", "looks"),
    [
        ((9.0, 9.5, 9.8), (10.0, 11.0, 9.7), "gallop", "cheaper:1", [1, 2]),
        # Of gaits that tie the first one is kept, which is the one that `select` names.
        ((9.0, 9.5, 9.8), (10.0, 10.5, 9.995), "walking", "fast", [1, 2]),
        # What a look has found is what the next one has to promise to be cheaper than.
        ((9.0, 9.5, 9.8), (10.0, 9.6, 9.7), "walking", "fast", [1]),
        ((9.0, 10.5, 9.8), (10.0, 9.6, 9.7), "gallop", "cheaper:1", [2]),
    ],
)
def test_all_that_may_be_cheaper_are_looked_at(
    gait_map: GaitMap, least: tuple, costs: tuple, gait: str, path: str, looks: list[int]
) -> None:
    walking, gallop = gait_map.gaits
    ranked = [(Candidate(0, 0), walking, 0.5), (Candidate(0, 1), walking, 0.5), (Candidate(1, 2), gallop, 0.4)]
    scripted = Scripted(gait_map, [SOLVED] * 3, [LOST] * 3, least, costs)
    plan = refine_ranked(scripted, ranked, Asked(TASK, VALUES, True, 0.0, 0.0))
    assert (plan.gait, plan.path) == (gait, path)
    assert plan.cost == pytest.approx(min(costs[0], *(costs[look] for look in looks)), rel=1e-3)
    assert scripted.calls == [FAST_0, *(("look", look) for look in looks)]


def test_what_may_save_half_is_looked_at_first_and_harder(gait_map: GaitMap) -> None:
    walking, gallop = gait_map.gaits
    ranked = [(Candidate(0, 0), walking, 0.5), (Candidate(0, 1), walking, 0.5), (Candidate(1, 2), gallop, 0.4)]
    scripted = Scripted(gait_map, [SOLVED] * 3, [LOST] * 3, (9.0, 9.5, 4.9), (10.0, 11.0, 9.7))
    plan = refine_ranked(scripted, ranked, Asked(TASK, VALUES, True, 0.0, 0.0))
    assert (plan.gait, plan.path) == ("gallop", "cheaper:1")
    assert scripted.calls == [FAST_0, ("look hard", 2), ("look", 1)]


@pytest.mark.parametrize(
    ("axes", "least", "gait", "calls"),
    [
        (2, (2.4, 12.4), "gallop", [FAST_0, LOOK_1]),
        (3, (2.4, 12.4), "gallop", [FAST_0, LOOK_1]),
        (2, (2.4, 12.6), "walking", [FAST_0]),
        (2, (2.6, 12.4), "walking", [FAST_0]),
        (2, (np.inf, 12.4), "walking", [FAST_0]),
        # Over many axes predictions are seldom right.
        (4, (2.4, 12.4), "walking", [FAST_0]),
    ],
)
def test_where_a_cost_is_far_above_what_it_might_have_been_dearer_gaits_are_looked_at(
    gait_map: GaitMap, axes: int, least: tuple[float, float], gait: str, calls: list[tuple[str, int]]
) -> None:
    ranked = [(Candidate(n, n), each, 0.01) for n, each in enumerate(gait_map.gaits)]
    scripted = Scripted(gait_map, [SOLVED] * 2, [LOST] * 2, least, (10.0, 9.0), axes)
    plan = refine_ranked(scripted, ranked, Asked(TASK, VALUES, True, 0.0, 0.0))
    assert (plan.gait, scripted.calls) == (gait, calls)


@pytest.mark.parametrize(
    ("ends", "gait", "path", "calls"),
    [
        ([SOLVED, SOLVED], "gallop", "cheaper:1", [FAST_0, ("look", 1)]),
        ([LOST, SOLVED], "walking", "failed", [FAST_0, SLOW_0]),
    ],
)
def test_of_gaits_that_are_not_tried_a_cheaper_one_is_looked_at(
    gait_map: GaitMap, ends: list, gait: str, path: str, calls: list[tuple[str, int]]
) -> None:
    walking, gallop = gait_map.gaits
    ranked = [(Candidate(0, 0), walking, 0.5), (Candidate(1, 1), gallop, 0.4)]
    scripted = Scripted(gait_map, ends, [LOST, LOST], (np.inf, 9.0), (10.0, 9.5))
    plan = refine_ranked(scripted, ranked, Asked(TASK, VALUES, True, 0.0, 0.0), top=1)
    assert (plan.gait, plan.path) == (gait, path)
    assert scripted.calls == calls


@pytest.mark.parametrize(
    ("axes", "chance", "gallop", "costs", "gait", "calls"),
    [
        # Of a likely gait one pattern is looked at, and the plan's own gait is one.
        (FEW_AXES, LIKELY_FEW, Candidate(1, 2), (10.0, 9.9, 9.8), "gallop", [FAST_0, ("fast", 2)]),
        (FEW_AXES, 0.99 * LIKELY_FEW, Candidate(1, 2), (10.0, 9.9, 9.8), "walking", [FAST_0]),
        (FEW_AXES + 1, LIKELY, Candidate(1, 2), (10.0, 9.9, 9.8), "gallop", [FAST_0, ("look", 2)]),
        (FEW_AXES + 1, LIKELY, Candidate(1, 2), (10.0, 9.9, 10.1), "walking", [FAST_0, ("look", 2)]),
        (FEW_AXES + 1, EVEN, Candidate(1, 2), (10.0, 9.9, 9.8), "gallop", [FAST_0, ("fast", 2)]),
        (FEW_AXES + 1, EVEN, Candidate(1, None), (10.0, 9.8, 9.8), "walking", [FAST_0]),
        (NEAR_AXES + 1, LIKELY_WIDE, Candidate(1, 2), (10.0, 9.9, 9.8), "gallop", [FAST_0, ("look", 2)]),
    ],
)
def test_likely_gaits_are_looked_at_in_any_case_and_the_likeliest_as_hard_as_the_first(
    gait_map: GaitMap, axes: int, chance: float, gallop: Candidate, costs: tuple, gait: str, calls: list
) -> None:
    first, second = gait_map.gaits
    ranked = [(Candidate(0, 0), first, 1 - chance), (Candidate(0, 1), first, 1 - chance), (gallop, second, chance)]
    scripted = Scripted(gait_map, [SOLVED] * 3, [LOST] * 3, (10.0, np.inf, np.inf), costs, axes)
    plan = refine_ranked(scripted, ranked, Asked(TASK, VALUES, True, 0.0, 0.0))
    assert plan.gait == gait and scripted.calls == calls


@pytest.mark.parametrize(
    ("axes", "chance", "first", "calls"),
    [
        (FEW_AXES, UNLIKELY / 2, 0.5, [FAST_0, ("look", 2), ("look", 1)]),
        (FEW_AXES + 1, UNLIKELY, 0.5, [FAST_0, ("look", 2), ("look", 1)]),
        (FEW_AXES + 1, UNLIKELY / 2, 0.5, [FAST_0, ("look", 1)]),
        (FEW_AXES + 1, 0.4, UNLIKELY / 2, [FAST_0, ("look", 2), ("look", 1)]),  # what comes first is spared by none
        (NEAR_AXES + 1, UNLIKELY / 2, 0.5, [FAST_0, ("look", 1)]),
    ],
)
def test_over_more_than_a_few_axes_an_unlikely_gait_is_not_looked_at(
    gait_map: GaitMap, axes: int, chance: float, first: float, calls: list[tuple[str, int]]
) -> None:
    walking, gallop = gait_map.gaits
    ranked = [(Candidate(0, 0), walking, first), (Candidate(0, 1), walking, first), (Candidate(1, 2), gallop, chance)]
    scripted = Scripted(gait_map, [SOLVED] * 3, [LOST] * 3, (10.0, 9.0, 8.0), (10.0, 9.5, 9.6), axes)
    refine_ranked(scripted, ranked, Asked(TASK, VALUES, True, 0.0, 0.0))
    assert scripted.calls == calls


@pytest.mark.parametrize(
    ("fast", "fallback", "gait", "path", "calls"),
    [
        ([LOST, SOLVED, SOLVED], [LOST] * 3, "walking", "fast", [FAST_0, FAST_1]),
        ([LOST, LOST, SOLVED], [LOST] * 3, "gallop", "next:1", [FAST_0, FAST_1, ("fast", 2)]),
        # IPOPT is asked once a gait.
        ([LOST] * 3, [LOST, LOST, SOLVED], "gallop", "next:1", [FAST_0, FAST_1, ("fast", 2), SLOW_0, ("fallback", 2)]),
    ],
)
def test_a_gait_is_tried_by_its_other_full_patterns_before_the_next_gait(
    gait_map: GaitMap, fast: list, fallback: list, gait: str, path: str, calls: list[tuple[str, int]]
) -> None:
    walking, gallop = gait_map.gaits
    ranked = [(Candidate(0, 0), walking, 0.5), (Candidate(0, 1), walking, 0.5), (Candidate(1, 2), gallop, 0.4)]
    scripted = Scripted(gait_map, fast, fallback, (np.inf,) * 3, (10.0, 11.0, 12.0))
    plan = refine_ranked(scripted, ranked, Asked(TASK, VALUES, True, 0.0, 0.0))
    assert (plan.gait, plan.path) == (gait, path)
    assert scripted.calls == calls
    assert [name for name, _ in plan.tried] == ["walking", "walking", "gallop"][: len(plan.tried)]
