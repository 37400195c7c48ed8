from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from tiny_map import TinyMap, cold_solve, task_of, write_map

from gaitflow.core import check
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Trajectory
from gaitflow.problem import GaitProblem
from gaitflow.runtime import GaitMap, OutOfDomain, Plan, refine
from gaitflow.runtime.atlas import NEAR_AXES, Atlas
from gaitflow.runtime.attempt import Attempt, Candidate, Effort
from gaitflow.runtime.plan import Asked, refine_ranked
from gaitflow.runtime.rivals import FEW_AXES, UNLIKELY

TASK, VALUES = task_of(0.9, 0.6), {"speed": 0.9, "cycle_duration": 0.6}
FAST = (2.05, 0.9)  # beyond what walking can do
TIMES = {"select_ms", "predict_ms", "refine_ms", "time_ms"}


@pytest.fixture(scope="module")
def gait_map(pristine: Path) -> GaitMap:
    return GaitMap.load(pristine)


@pytest.fixture(scope="module")
def walker(preferring: Callable[[str], TinyMap], tmp_path_factory: pytest.TempPathFactory) -> GaitMap:
    """A map without an atlas that ranks walking first everywhere."""
    return GaitMap.load(write_map(bare(preferring("walking")), tmp_path_factory.mktemp("walker")))


def bare(tiny: TinyMap) -> TinyMap:
    """The same map whose atlas knows nothing."""
    return dataclasses.replace(tiny, atlas=Atlas.empty(tuple(tiny.domain.axes)))


@pytest.fixture
def slow(monkeypatch: pytest.MonkeyPatch) -> None:
    """The fast method has no iterations to spend."""
    monkeypatch.setattr(refine, "LIMIT", 0)


def _checked(problem: GaitProblem, plan: Plan, speed: float, cycle: float) -> float:
    return check.worst(problem.scenario.as_data(), plan, task_of(speed, cycle), plan.pattern)


def assert_same(one: Plan, other: Plan) -> None:
    """Bit by bit, but for the times."""
    for field in dataclasses.fields(Plan):
        if field.name not in TIMES:
            np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name), err_msg=field.name)


@pytest.mark.parametrize(("speed", "cycle"), [(0.3, 0.6), (0.55, 1.1), (0.9, 0.6), (1.7, 0.6), FAST])
def test_plans_are_feasible_and_no_dearer_than_a_fresh_solve(
    gait_map: GaitMap, tiny: TinyMap, speed: float, cycle: float
) -> None:
    plan = gait_map.plan(speed=speed, cycle_duration=cycle)
    assert plan.feasible
    assert plan.path == "fast"
    assert plan.tried == ((plan.gait, "solved, fast"),)
    assert plan.violation == _checked(tiny.problem, plan, speed, cycle) <= 1e-6
    assert plan.durations.sum() == pytest.approx(cycle)
    assert plan.base[-1, 0] - plan.base[0, 0] == pytest.approx(speed * cycle)
    fresh = cold_solve(tiny.problem, plan.pattern, speed, cycle)
    assert fresh.feasible
    assert 0.95 * fresh.cost < plan.cost <= fresh.cost * (1 + 1e-6)  # the start may lead to a better minimum


def test_the_gait_is_the_cheapest_whatever_the_classifier_says(
    gait_map: GaitMap, preferring: Callable[[str], TinyMap], tiny: TinyMap, tmp_path: Path
) -> None:
    wrong = GaitMap.load(write_map(preferring("gallop"), tmp_path))
    for task in ((0.3, 0.6), (0.55, 1.1)):
        plan, other = gait_map.plan(*task), cold_solve(tiny.problem, "0110/1100", *task)
        assert other.feasible and plan.cost < other.cost
        assert wrong.select(*task).gait == gait_map.select(*task).gait == "walking"
        assert (wrong.plan(*task).gait, wrong.plan(*task).cost) == (plan.gait, plan.cost) == ("walking", plan.cost)


def test_a_prediction_saves_most_iterations(gait_map: GaitMap, tiny: TinyMap) -> None:
    for task in ((0.35, 0.63), (1.27, 0.85), (1.63, 0.55)):
        plan = gait_map.plan(*task)
        assert plan.iterations <= 6 < cold_solve(tiny.problem, plan.pattern, *task).iterations


def test_shapes_of_a_plan(gait_map: GaitMap) -> None:
    plan = gait_map.plan(0.9, 0.6)
    assert plan.times.shape == (17,)
    assert plan.base.shape == (17, 6)
    assert plan.feet.shape == (17, 2, 2)
    assert plan.forces.shape == plan.foot_velocities.shape == (16, 2, 2)
    assert plan.durations.shape == (4,)


def test_times_add_up(gait_map: GaitMap, walker: GaitMap) -> None:
    for plan in (gait_map.plan(0.9, 0.6), walker.plan(*FAST)):
        assert min(plan.select_ms, plan.predict_ms, plan.refine_ms) > 0
        assert plan.select_ms + plan.predict_ms + plan.refine_ms <= plan.time_ms


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("task", [(0.3, 0.6), (1.27, 0.85)])
def test_ipopt_takes_over_where_the_fast_method_fails(
    gait_map: GaitMap, tiny: TinyMap, task: tuple[float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = gait_map.plan(*task)
    assert plan.feasible and plan.path == "fallback"
    assert plan.tried[0] == (plan.gait, "solved, fallback")
    assert all("not converged" in outcome for _, outcome in plan.tried[1:])
    assert _checked(tiny.problem, plan, *task) <= 1e-6
    monkeypatch.undo()
    quick = gait_map.plan(*task)
    assert quick.path == "fast"
    assert quick.gait == plan.gait and quick.cost == pytest.approx(plan.cost, rel=1e-6)


@pytest.mark.usefixtures("slow")
def test_a_map_without_an_atlas_falls_back_too(walker: GaitMap, tiny: TinyMap) -> None:
    plan = walker.plan(0.3, 0.6)
    assert (plan.gait, plan.feasible) == ("walking", True)
    assert _checked(tiny.problem, plan, 0.3, 0.6) <= 1e-6


def test_a_plan_is_a_motion_at_any_time(gait_map: GaitMap, tiny: TinyMap) -> None:
    """Of Euler's rule: smooth, and past the knots by millimetres."""
    plan = gait_map.plan(0.9, 0.6)
    motion = plan.motion()
    assert (motion.leg_names, motion.period, plan.frames) == (tiny.problem.scenario.robot.leg_names, 0.6, None)
    seen = motion.sample(plan.times)
    np.testing.assert_allclose(seen.position, plan.base[:, :2], atol=0.02)
    np.testing.assert_allclose(seen.velocity, plan.base[:, 3:5], atol=0.05)
    fine = motion.sample(np.linspace(-0.6, 1.2, 20001))
    step = 1.8 / 20000
    assert np.abs(np.diff(fine.position, axis=0) / step - fine.velocity[:-1]).max() < 20 * step
    np.testing.assert_allclose(fine.position[-1] - fine.position[0], [0.9 * 1.8, 0.0], atol=1e-9)
    np.testing.assert_allclose(fine.velocity[-1], fine.velocity[0], atol=1e-9)
    gravity = np.array([0.0, -9.81])
    pushed = fine.forces.sum(axis=1) / tiny.problem.scenario.robot.mass + gravity
    np.testing.assert_allclose(fine.acceleration, pushed, atol=1e-5)
    own = plan.motion(swing_apex=None).sample(plan.times)
    np.testing.assert_allclose(own.feet, plan.feet, atol=1e-6)
    with pytest.raises(ValueError, match='point = "base": the map quickstart does not know'):
        plan.motion(point="base")


def test_swings_are_as_high_as_the_map_counts_on(gait_map: GaitMap) -> None:
    plan = gait_map.plan(0.9, 0.6)
    low = dataclasses.replace(plan, scenario={**plan.scenario, "swing_clearance": 0.025})
    times = np.linspace(0.0, 0.6, 6001)
    for motion, apex in (
        (plan.motion(), 0.05),
        (low.motion(), 0.025),
        (low.motion(swing_apex=0.08), 0.08),
    ):
        assert motion.swing_apex == apex
        assert motion.sample(times).feet[..., -1].max() == pytest.approx(apex, abs=1e-4)
    assert low.motion(swing_apex=None).swing_apex is None
    with pytest.raises(ValueError, match="swing_apex = 'high'"):
        plan.motion(swing_apex="high")  # type: ignore[arg-type]


@pytest.mark.parametrize("gait", ["walking", "gallop"])
def test_a_gait_may_be_asked_for_by_name(gait_map: GaitMap, tiny: TinyMap, gait: str) -> None:
    plan = gait_map.plan(0.9, 0.6, gait=gait)
    assert (plan.gait, plan.path, plan.feasible) == (gait, "fast", True)
    assert plan.tried == ((gait, "solved, fast"),)
    assert plan.probability == dict(gait_map.select(0.9, 0.6).ranked)[gait]
    assert _checked(tiny.problem, plan, 0.9, 0.6) <= 1e-6


def test_a_gait_asked_for_is_the_only_one_that_is_tried(walker: GaitMap) -> None:
    plan = walker.plan(*FAST, gait="walking")
    assert (plan.gait, plan.path, plan.feasible) == ("walking", "failed", False)
    assert {gait for gait, _ in plan.tried} == {"walking"}


def test_a_gait_that_the_map_lacks_is_refused_with_those_it_has(gait_map: GaitMap) -> None:
    with pytest.raises(ValueError, match="gait = 'trot': the map has walking, gallop"):
        gait_map.plan(0.9, 0.6, gait="trot")


def test_the_next_gait_is_tried_and_said(walker: GaitMap, tiny: TinyMap) -> None:
    plan = walker.plan(*FAST)
    assert plan.feasible
    assert (plan.gait, plan.path) == ("gallop", "next:1")
    assert plan.probability == walker.select(*FAST).ranked[1][1]
    (first, why), (second, outcome) = plan.tried
    assert (first, second, outcome) == ("walking", "gallop", "solved, fast")
    assert why.startswith("infeasible: violation ")
    assert _checked(tiny.problem, plan, *FAST) <= 1e-6


def test_failure_is_said_with_the_least_infeasible_motion(walker: GaitMap, tiny: TinyMap) -> None:
    plan = walker.plan(*FAST, top=1)
    assert not plan.feasible
    assert (plan.gait, plan.path, len(plan.tried)) == ("walking", "failed", 1)
    assert plan.violation == _checked(tiny.problem, plan, *FAST) > 1e-3


@pytest.mark.usefixtures("slow")
def test_a_solver_that_stops_early_is_not_believed(artifact: Path, tiny: TinyMap) -> None:
    hasty = dataclasses.replace(bare(tiny), solver_options={"max_iter": 1})
    plan = GaitMap.load(write_map(hasty, artifact.parents[1] / "hasty")).plan(0.55, 1.1)
    assert plan.path == "failed"
    assert [gait for gait, _ in plan.tried] == ["walking", "gallop"]
    assert all("Maximum_Iterations_Exceeded" in outcome for _, outcome in plan.tried)


@pytest.mark.usefixtures("slow")
def test_a_solver_that_throws_costs_one_start(artifact: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gait_map = GaitMap.load(artifact)
    problem = gait_map._solvers.refiner()._problem
    real, calls = problem._ipopt, []

    class Throwing:
        def __call__(self, **arguments: object) -> object:
            calls.append(1)
            if len(calls) == 1:
                raise RuntimeError("Error in Function::call\nsingular")
            return real(**arguments)

        def stats(self) -> dict:
            return real.stats()

        def numel_in(self, name: str) -> int:
            return real.numel_in(name)

    monkeypatch.setitem(vars(problem), "_ipopt", Throwing())
    plan = gait_map.plan(0.9, 0.6)
    assert plan.feasible and len(calls) == 2
    assert (plan.gait, plan.path) == ("walking", "fallback"), "the mean of its region was the second start"
    monkeypatch.setattr(Throwing, "__call__", lambda self, **arguments: (_ for _ in ()).throw(RuntimeError("a\nb")))
    failed = gait_map.plan(0.9, 0.6)
    assert failed.path == "failed"
    assert all("exception: b" in outcome for _, outcome in failed.tried)


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
        # Over many axes predictions are seldom right, and likely gaits are looked at in any case.
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
    ("axes", "gallop", "costs", "gait", "calls"),
    [
        (FEW_AXES, Candidate(1, 2), (10.0, 9.9, 9.8), "walking", [FAST_0]),
        # Of a likely gait one pattern is looked at, and the plan's own gait is one.
        (FEW_AXES + 1, Candidate(1, 2), (10.0, 9.9, 9.8), "gallop", [FAST_0, ("look", 2)]),
        (FEW_AXES + 1, Candidate(1, 2), (10.0, 9.9, 10.1), "walking", [FAST_0, ("look", 2)]),
        (FEW_AXES + 1, Candidate(1, None), (10.0, 9.8, 9.8), "walking", [FAST_0]),
    ],
)
def test_over_more_than_a_few_axes_likely_gaits_are_looked_at_in_any_case(
    gait_map: GaitMap, axes: int, gallop: Candidate, costs: tuple, gait: str, calls: list[tuple[str, int]]
) -> None:
    first, second = gait_map.gaits
    ranked = [(Candidate(0, 0), first, 0.2), (Candidate(0, 1), first, 0.2), (gallop, second, 0.8)]
    scripted = Scripted(gait_map, [SOLVED] * 3, [LOST] * 3, (10.0, np.inf, np.inf), costs, axes)
    plan = refine_ranked(scripted, ranked, Asked(TASK, VALUES, True, 0.0, 0.0))
    assert plan.gait == gait and scripted.calls == calls


@pytest.mark.parametrize(
    ("axes", "chance", "first", "calls"),
    [
        (FEW_AXES, UNLIKELY / 2, 0.5, [FAST_0, ("look", 2), ("look", 1)]),
        (FEW_AXES + 1, UNLIKELY, 0.5, [FAST_0, ("look", 2), ("look", 1)]),
        (FEW_AXES + 1, UNLIKELY / 2, 0.5, [FAST_0, ("look", 1)]),
        (FEW_AXES + 1, 0.5, UNLIKELY / 2, [FAST_0, ("look", 2), ("look", 1)]),  # what comes first is spared by none
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


@pytest.mark.parametrize("top", [0, -1, 1.5, "2", None, True])
def test_bad_top_is_refused(gait_map: GaitMap, top: object) -> None:
    with pytest.raises(ValueError, match="top = "):
        gait_map.plan(0.9, 0.6, top=top)


BEYOND = [(2.25, 0.6), (2.0, 0.45), (0.02, 0.5), (0.9, 1.3)]


@pytest.mark.parametrize(("speed", "cycle"), BEYOND)
def test_beyond_the_domain_a_plan_has_to_be_asked_for_and_is_checked_all_the_same(
    gait_map: GaitMap, tiny: TinyMap, speed: float, cycle: float
) -> None:
    with pytest.raises(OutOfDomain):
        gait_map.plan(speed, cycle)
    plan = gait_map.plan(speed, cycle, beyond=True)
    assert plan.in_domain is False
    assert plan.distance == gait_map.select(speed, cycle).distance > 0
    assert plan.feasible is (_checked(tiny.problem, plan, speed, cycle) <= 1e-6)
    if plan.feasible:
        assert plan.base[-1, 0] - plan.base[0, 0] == pytest.approx(speed * cycle)


def test_beyond_changes_nothing_inside(gait_map: GaitMap) -> None:
    assert_same(gait_map.plan(0.9, 0.6), gait_map.plan(0.9, 0.6, beyond=True))


@pytest.mark.parametrize("task", [(19.0, 0.6), (-20.0, 20.0), (2.0, 20.0)])
@pytest.mark.filterwarnings("error")
def test_however_far_beyond_a_plan_ends_without_a_motion_and_says_so(gait_map: GaitMap, task: tuple) -> None:
    plan = gait_map.plan(*task, beyond=True)
    assert (plan.path, plan.feasible) == ("failed", False)
    assert 0 <= plan.probability <= 1
    assert plan.violation > 1e-6


def _tasks(gait_map: GaitMap, count: int, seed: int) -> list[tuple[float, float]]:
    drawn = np.random.default_rng(seed).uniform((0.1, 0.4), (2.1, 1.2), (2 * count, 2)).tolist()
    return [(v, t) for v, t in drawn if gait_map.manifest.domain.contains({"speed": v, "cycle_duration": t})][:count]


@pytest.mark.parametrize("seed", range(3))
def test_random_tasks_refine_and_pass_the_check(gait_map: GaitMap, tiny: TinyMap, seed: int) -> None:
    for task in _tasks(gait_map, 40, seed):
        plan = gait_map.plan(*task)
        assert plan.feasible, task
        assert _checked(tiny.problem, plan, *task) == plan.violation <= 1e-6


def test_plans_repeat_bit_by_bit(pristine: Path) -> None:
    one, other = GaitMap.load(pristine), GaitMap.load(pristine)
    tasks = _tasks(one, 30, 7)
    first = {task: one.plan(*task) for task in tasks}
    for task in reversed(tasks):  # what was planned before leaves no trace
        assert_same(other.plan(*task), first[task])


def test_many_threads_plan_as_one_does(pristine: Path) -> None:
    gait_map = GaitMap.load(pristine)
    tasks = _tasks(gait_map, 80, 11)
    assert len(tasks) == 80
    barrier, plans = threading.Barrier(8), [{} for _ in range(8)]

    def ask(number: int) -> None:
        barrier.wait()
        for n in range(len(tasks)):
            task = tasks[(n + 10 * number) % len(tasks)]
            plans[number][task] = gait_map.plan(*task)

    threads = [threading.Thread(target=ask, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    alone = {task: GaitMap.plan(gait_map, *task) for task in tasks}
    for found in plans:
        assert len(found) == len(tasks)
        for task in tasks:
            assert_same(found[task], alone[task])


@pytest.mark.usefixtures("slow")
def test_threads_take_turns_at_ipopt(artifact: Path) -> None:
    gait_map = GaitMap.load(artifact)
    tasks = [(0.3, 0.6), (0.9, 0.6), (1.3, 0.8), (1.7, 0.6)]
    plans: dict[tuple[float, float], Plan] = {}
    threads = [
        threading.Thread(target=lambda task=task: plans.__setitem__(task, gait_map.plan(*task))) for task in tasks
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for task in tasks:
        alone = gait_map.plan(*task)
        assert plans[task].feasible and plans[task].path == "fallback"
        assert plans[task].cost == pytest.approx(alone.cost, rel=1e-9)


def test_only_energy_is_a_cost_of_transport(gait_map: GaitMap) -> None:
    plan = gait_map.plan(**VALUES)
    assert plan.cost_of_transport is None
    energy = dataclasses.replace(plan, scenario={**plan.scenario, "objective": {"joint_heat": 0.0, "joint_work": 1.0}})
    assert energy.cost_of_transport == pytest.approx(plan.cost / (plan.scenario["robot"]["mass"] * 9.81 * 0.9 * 0.6))
