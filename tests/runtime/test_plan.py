from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from tiny_map import TinyMap, cold_solve, task_of, write_map

from gaitflow.core import check
from gaitflow.problem import GaitProblem
from gaitflow.runtime import GaitMap, OutOfDomain, Plan, refine
from gaitflow.runtime.atlas import Atlas

VALUES = {"speed": 0.9, "cycle_duration": 0.6}
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
    assert plan.tried[0] == (plan.gait, "solved, fast"), "the classifier may have another one tried"
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
