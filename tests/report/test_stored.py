"""Finding a motion in a dataset."""

from __future__ import annotations

import numpy as np
import pytest

from gaitflow.report.stored import chosen, motion_of, nearest_task, ranked_gaits, scenario_of

TASK = {"speed": 1.0, "cycle_duration": 0.6}


def test_the_nearest_task_is_measured_in_shares_of_the_map(published) -> None:
    frame = published.frame()
    solved = frame[frame["status"] == "solved"]
    exact = solved.iloc[1000]
    task = nearest_task(published, {axis: exact[axis] for axis in ("speed", "cycle_duration")})
    assert (task.speed, task.cycle_duration) == (exact["speed"], exact["cycle_duration"])
    far = nearest_task(published, {"speed": 19.0, "cycle_duration": 19.0})
    assert (far.speed, far.cycle_duration) == (solved["speed"].max(), solved["cycle_duration"].max())


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"speed": np.nan, "cycle_duration": 0.6}, "speed = nan m/s: must lie in"),
        ({"speed": 1.0, "cycle_duration": np.inf}, "cycle_duration = inf s: must lie in"),
        ({"speed": 1.0}, "needs cycle_duration as well"),
        ({"speed": 1.0, "cycle_duration": 0.6, "slope": 3.0}, "slope = 3: it is fixed at 0 deg here"),
        ({"speed": 1.0, "cycle_duration": 0.6, "slop": 3.0}, "axis 'slop' is unknown here"),
    ],
)
def test_what_is_no_task_of_the_dataset_is_refused(published, values, says) -> None:
    with pytest.raises(ValueError, match=says):
        nearest_task(published, values)


def test_a_dataset_without_solutions_is_refused(published) -> None:
    unsolved = int(np.flatnonzero(published.frame()["status"] != "solved")[0])
    with pytest.raises(ValueError, match="no task of the dataset is solved"):
        nearest_task(published[unsolved : unsolved + 1], TASK)


def test_gaits_are_ranked_by_cost_and_the_cheapest_have_motions(published) -> None:
    task = nearest_task(published, TASK)
    ranked = ranked_gaits(published, task)
    assert [one.rank for one in ranked] == list(range(1, len(ranked) + 1))
    assert sorted(one.cost for one in ranked) == [one.cost for one in ranked]
    assert [one.has_motion for one in ranked[:4]] == [True, True, True, False]
    assert len({one.gait for one in ranked}) == len(ranked)
    for one in ranked[:3]:
        solution = motion_of(published, one)
        assert solution.task == task
        assert (solution.pattern, solution.cost) == (one.pattern, one.cost)
        assert solution.trajectory is not None


def test_a_gait_is_chosen_by_name_or_rank(published) -> None:
    ranked = ranked_gaits(published, nearest_task(published, TASK))
    assert chosen(ranked, None, None) is ranked[0]
    assert chosen(ranked, None, 2) is ranked[1]
    assert chosen(ranked, ranked[2].gait, None) is ranked[2]
    with pytest.raises(ValueError, match=f"gait 'moonwalk': not among the .* with a motion: 1 {ranked[0].gait}"):
        chosen(ranked, "moonwalk", None)
    with pytest.raises(ValueError, match="rank 4: only its cost was stored"):
        chosen(ranked, None, 4)


def test_the_scenario_of_a_dataset(published) -> None:
    assert scenario_of(published).name == "half-cheetah-flat-effort"
