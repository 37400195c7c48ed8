"""A map is planned at random tasks before its certificate is asked, and learns where its picks end."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from gaitflow.config.scenario import load_scenario
from gaitflow.core.domain import Domain
from gaitflow.core.task import Task
from gaitflow.sampling.picks import Suspect
from gaitflow.sampling.rehearsal import DRAWS, rehearse, where_missing

SCENARIO = Path(__file__).parents[2] / "configs/scenarios/half-cheetah-exact-vibration.yaml"


class Making:
    """A map whose picks have a motion below a limit of the speed; it learns `learnt` of what is beyond a draw."""

    def __init__(self, limit: float, learnt: float) -> None:
        self.scenario = load_scenario(SCENARIO)
        axes = {axis: values.values for axis, values in self.scenario.tasks.ranges.items()}
        self.domain = Domain(axes, np.ones(tuple(map(len, axes.values())), dtype=bool))
        self.limit, self.learnt = limit, learnt
        self.drawn: list[Task] = []
        self.told: list[str] = []
        self.tell = self.told.append

    def suspects(self, tasks: Sequence[Task]) -> list[Suspect]:
        self.drawn += tasks
        return [Suspect(task, frozenset({0}), True) for task in tasks if task.speed >= self.limit]

    def look_closely(self, suspects: Sequence[Suspect]) -> None:
        assert all(one.task.speed >= self.limit for one in suspects)
        self.limit += self.learnt


def test_a_map_whose_picks_all_have_a_motion_is_drawn_once() -> None:
    making = Making(limit=99.0, learnt=0.0)
    assert rehearse(making, making, 50, 7) == []  # type: ignore[arg-type]
    assert len(making.drawn) == 50
    assert making.told == ["of 50 random picks 0 are suspicious, 0 have no motion"]


def test_it_is_drawn_anew_until_it_has_learnt() -> None:
    making = Making(limit=1.0, learnt=99.0)
    assert rehearse(making, making, 50, 7) == []  # type: ignore[arg-type]
    assert len(making.drawn) == 100 == len(set(making.drawn)), "no task twice"


def test_what_it_does_not_learn_is_told() -> None:
    making = Making(limit=1.0, learnt=0.0)
    without = rehearse(making, making, 50, 7)  # type: ignore[arg-type]
    assert [one.task for one in without] == [task for task in making.drawn[-50:] if task.speed >= 1.0] != []
    assert len(making.drawn) == 50 * DRAWS


@pytest.mark.parametrize("seeds", [(7, 7), (7, 8000)])
def test_equal_seeds_draw_equal_tasks(seeds: tuple[int, int]) -> None:
    runs = [SimpleNamespace(making=Making(99.0, 0.0), seed=seed) for seed in seeds]
    for one in runs:
        rehearse(one.making, one.making, 20, one.seed)  # type: ignore[arg-type]
    assert (runs[0].making.drawn == runs[1].making.drawn) == (seeds[0] == seeds[1])


def test_each_missing_gait_has_the_task_where_it_saves_most() -> None:
    space = load_scenario(SCENARIO).tasks.space
    first, second, third = (space.task({"speed": speed, "cycle_duration": 0.5}, "sampled") for speed in (0.5, 0.6, 0.7))
    suspects = [
        Suspect(first, frozenset({0}), False, {1: 0.02, 2: 0.05}),
        Suspect(second, frozenset({0}), False, {1: 0.03}),
        Suspect(third, frozenset({0}), True, {}),
    ]
    assert where_missing(suspects) == [(first, 0.05), (second, 0.03)], "where no gait is missing none is searched"
    both = [Suspect(first, frozenset({0}), False, {1: 0.02, 2: 0.05})]
    assert where_missing(both) == [(first, 0.05)], "a task once"
