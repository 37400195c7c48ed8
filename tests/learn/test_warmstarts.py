"""Region means: which pattern, which tasks, and the mean itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tasks_at import at

from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.learn.warmstarts import region_means
from gaitflow.search.solution import Solution
from gaitflow.solvers.point import Multipliers

AABC, ABBC = "0010/1110", "0110/1110"  # one gait
DDEF = "0110/1100"
WALK, GALLOP = (gait_of(Pattern.from_text(pattern)).text for pattern in (AABC, DDEF))
LABELS = pd.DataFrame(
    [
        (0.1, 1.0, "grid", "solved", "walking", WALK, "walking"),
        (0.2, 1.0, "grid", "solved", "walking", WALK, "walking"),
        (0.3, 2.0, "grid", "solved", "gallop", GALLOP, "walking"),  # a tie: labelled as its neighbours
        (0.4, 1.0, "grid", "solved", "gallop", GALLOP, "gallop"),
        (0.5, 1.0, "grid", "infeasible", "", "", ""),
        (0.1, 1.5, "held_out", "solved", "walking", WALK, "walking"),
    ],
    columns=["speed", "cycle_duration", "split", "status", "gait", "gait_key", "label"],
)


def solution(speed: float, cycle: float, gait: str, pattern: str, cost: float, value: float) -> Solution:
    """A solution all of whose numbers are `value`, its durations `value * cycle`."""
    trajectory = Trajectory(
        times=np.linspace(0, cycle, 3),
        base=np.full((3, 6), value),
        feet=np.full((3, 2, 2), value),
        forces=np.full((2, 2, 2), value),
        end_forces=np.full((2, 2, 2), value),
        foot_velocities=np.full((2, 2, 2), value),
        durations=np.full(2, value * cycle),
    )
    return Solution(
        task=at(speed, cycle),
        pattern=pattern,
        gait=gait,
        strategy="patterns",
        start="nominal",
        seed=0,
        status="solved",
        solver_status="Solve_Succeeded",
        cost=cost,
        violation=1e-9,
        iterations=1,
        solves=1,
        wall_s=0.1,
        cpu_s=0.1,
        trajectory=trajectory,
        multipliers=Multipliers(bounds=np.full(4, 10 * value), rows=np.full(3, 100 * value)),
    )


def pack(trajectory: Trajectory, cycle_duration: float, pattern: str) -> Array:
    return np.concatenate([trajectory.base[0, :2], trajectory.durations / cycle_duration])


WALKS = [
    solution(0.1, 1.0, WALK, AABC, cost=1.0, value=1.0),
    solution(0.1, 1.0, WALK, ABBC, cost=2.0, value=50.0),
    solution(0.2, 1.0, WALK, AABC, cost=1.0, value=2.0),
    solution(0.3, 2.0, WALK, AABC, cost=1.5, value=6.0),  # dearer here, but its task belongs to the region
    solution(0.3, 2.0, WALK, ABBC, cost=1.0, value=60.0),
]
GALLOPS = [
    solution(0.3, 2.0, GALLOP, DDEF, cost=0.9, value=80.0),
    solution(0.4, 1.0, GALLOP, DDEF, cost=1.0, value=3.0),
]


def test_the_mean_over_the_region_of_the_pattern_that_is_best_most_often() -> None:
    gallop, walking = region_means(LABELS, WALKS + GALLOPS, pack)
    assert (walking.gait, walking.pattern, walking.tasks) == ("walking", AABC, 3)
    np.testing.assert_allclose(walking.primal, [3.0] * 4)
    np.testing.assert_allclose(walking.bounds, [30.0] * 4)
    np.testing.assert_allclose(walking.rows, [300.0] * 3)
    assert (gallop.gait, gallop.pattern, gallop.tasks) == ("gallop", DDEF, 1)
    np.testing.assert_allclose(gallop.primal, [3.0] * 4)


def test_what_does_not_belong_to_the_region_has_no_influence() -> None:
    expected = region_means(LABELS, WALKS + GALLOPS, pack)
    extra = [
        replace(WALKS[0], task=at(0.1, 1.5, "held_out"), cost=0.1),
        replace(solution(0.1, 1.0, WALK, AABC, 0.1, 99.0), task=at(0.1, 1.0, "held_out")),
        replace(solution(0.2, 1.0, WALK, AABC, 0.1, 99.0), violation=1e-3),
        replace(solution(0.2, 1.0, WALK, AABC, 0.1, 99.0), status="failed"),
        replace(solution(0.2, 1.0, WALK, AABC, 0.1, 99.0), multipliers=None),
        replace(solution(0.2, 1.0, WALK, AABC, 0.1, 99.0), trajectory=None),
        solution(0.4, 1.0, WALK, AABC, 0.1, 99.0),
        solution(0.7, 1.0, WALK, AABC, 0.1, 99.0),
    ]
    for before, after in zip(expected, region_means(LABELS, extra + WALKS + GALLOPS, pack), strict=True):
        assert (before.gait, before.pattern, before.tasks) == (after.gait, after.pattern, after.tasks)
        np.testing.assert_array_equal(before.primal, after.primal)


def test_the_cheapest_of_several_solves_of_one_pattern_speaks_for_its_task() -> None:
    worse = solution(0.4, 1.0, GALLOP, DDEF, cost=1.1, value=99.0)
    for solutions in ([*GALLOPS, worse], [worse, *GALLOPS]):
        gallop, _ = region_means(LABELS, WALKS + solutions, pack)
        assert gallop.tasks == 1
        np.testing.assert_allclose(gallop.primal, [3.0] * 4)


def test_a_gait_without_trajectories_is_named() -> None:
    bare = [replace(one, trajectory=None) for one in GALLOPS]
    with pytest.raises(ValueError, match="gait 'gallop': no solution of its region"):
        region_means(LABELS, WALKS + bare, pack)


def test_a_pattern_that_is_another_gait_elsewhere_in_the_map_does_not_count() -> None:
    """Where time reversal leaves a task as it is, one row may stand for two gaits."""
    merged = replace(solution(0.4, 1.0, GALLOP, "0001/0100", cost=0.1, value=99.0), gait=GALLOP)
    _, walking = region_means(LABELS, [*WALKS, *GALLOPS, merged], pack)
    gallop, _ = region_means(LABELS, [*WALKS, *GALLOPS, merged], pack)
    assert walking.gait == "walking" and gallop.pattern == GALLOPS[0].pattern
    np.testing.assert_allclose(gallop.primal, [3.0] * 4)


def test_a_region_lies_over_any_axes() -> None:
    labels = LABELS.assign(slope=[0.0, 5.0, 0.0, 0.0, 0.0, 0.0])[["slope", *LABELS.columns]]
    tilted = replace(WALKS[2], task=WALKS[2].task.replaced(slope=5.0))
    level = replace(WALKS[2], cost=0.1)  # of a task that the labels do not have
    _, walking = region_means(labels, [*WALKS[:2], level, tilted, *WALKS[3:], *GALLOPS], pack)
    assert walking.tasks == 3
    np.testing.assert_allclose(walking.primal, [3.0] * 4)
