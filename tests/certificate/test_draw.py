"""Tasks of a certificate are random, inside the domain, and the same for the same seed."""

from __future__ import annotations

import numpy as np
import pytest

from gaitflow.certificate.draw import EmptyDomain, draw_tasks
from gaitflow.core.domain import Domain
from gaitflow.core.task_space import TaskSpace

SPACE = TaskSpace(("speed", "cycle_duration"), ())


def domain(feasible: list[list[bool]]) -> Domain:
    return Domain({"speed": (0.0, 1.0, 2.0), "cycle_duration": (0.5, 1.0)}, np.array(feasible))


def test_only_what_lies_inside_is_drawn() -> None:
    half = domain([[True, True], [True, True], [False, True]])
    tasks = draw_tasks(half, SPACE, 200, 3, "held_out")
    assert len(set(tasks)) == 200 and all(half.contains(task) for task in tasks)
    assert {task.split for task in tasks} == {"held_out"}
    assert np.mean([task.speed for task in tasks]) == pytest.approx(0.5, abs=0.1), "equally likely anywhere in it"


def test_a_hole_in_the_domain_is_left_out() -> None:
    feasible = np.ones((5, 5), dtype=bool)
    feasible[2, 2] = False
    axes = {"speed": (0.0, 0.5, 1.0, 1.5, 2.0), "cycle_duration": (0.4, 0.5, 0.6, 0.7, 0.8)}
    holed = Domain(axes, feasible)
    tasks = draw_tasks(holed, SPACE, 300, 1, "held_out")
    in_hole = [task for task in tasks if 0.5 < task.speed < 1.5 and 0.5 < task.cycle_duration < 0.7]
    assert not in_hole and all(holed.contains(task) for task in tasks)
    assert min(task.speed for task in tasks) < 0.1 and max(task.speed for task in tasks) > 1.9, "all around it"


def test_more_tasks_go_on_where_fewer_ended() -> None:
    whole = domain([[True, True]] * 3)
    first = draw_tasks(whole, SPACE, 5, 7, "sampled")
    assert [*first, *draw_tasks(whole, SPACE, 3, 7, "sampled", skip=5)] == draw_tasks(whole, SPACE, 8, 7, "sampled")
    assert first != draw_tasks(whole, SPACE, 5, 8, "sampled")


def test_a_domain_without_a_cell_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gaitflow.certificate.draw.TRIES", 1000)
    nothing = domain([[True, False], [False, True], [True, False]])
    with pytest.raises(EmptyDomain, match=r"none of 1000 random tasks between \(0.0, 0.5\) and \(2.0, 1.0\)"):
        draw_tasks(nothing, SPACE, 1, 0, "held_out")
