"""The tangent of the central path, against the path itself at tasks nearby."""

from __future__ import annotations

import numpy as np
import pytest
from tasks_at import at
from two_gaits import GAITS

from gaitflow.core.task import AXES
from gaitflow.problem import GaitProblem
from gaitflow.solvers.interior_point import InteriorPoint
from gaitflow.solvers.point import Point
from gaitflow.solvers.program import Program

BARRIER = 1e-4
NAMES = list(AXES)
Centred = tuple[InteriorPoint, Point, np.ndarray, float]


@pytest.fixture(params=list(GAITS))
def centred(
    request: pytest.FixtureRequest, program: Program, solved: dict
) -> tuple[InteriorPoint, Point, np.ndarray, float]:
    """A gait's method, its central-path point at a task, that task, and the unit of cost."""
    gait = solved[request.param]
    method, task = InteriorPoint(program, gait.space), at(*GAITS[request.param][1:]).parameters
    outcome = method.centre(task, gait.point, gait.unit, BARRIER, 60)
    assert outcome.converged
    return method, outcome.point, task, gait.unit


@pytest.mark.parametrize(("axis", "h"), [("speed", 2e-3), ("cycle_duration", 2e-3), ("friction", 5e-2)])
def test_is_the_slope_of_the_central_path(centred: tuple, axis: str, h: float) -> None:
    method, point, task, unit = centred
    tangent = method.tangent(task, point, unit, BARRIER)
    assert tangent.shape == (len(AXES), method.space.size)
    step = h * np.eye(len(task))[NAMES.index(axis)]
    ends = []
    for beside in (task + step, task - step):
        outcome = method.centre(beside, point, unit, BARRIER, 60)
        assert outcome.converged
        ends.append(method.space.encode(outcome.point))
    expected = (ends[0] - ends[1]) / (2 * h)
    found = tangent[NAMES.index(axis)]
    # `centre` leaves a relative deviation of 0.01 in each product, so of 0.01 / h in a slope of its logarithm.
    assert np.linalg.norm(found - expected) <= 0.05 * np.linalg.norm(expected)


def test_axes_that_do_not_matter_have_none(centred: tuple) -> None:
    method, point, task, unit = centred
    tangent = method.tangent(task, point, unit, BARRIER)
    for axis in ("lateral_speed", "yaw_rate", "acceleration", "slope"):
        assert not tangent[NAMES.index(axis)].any(), axis


def test_saves_iterations_at_a_task_beside(centred: tuple) -> None:
    method, point, task, unit = centred
    beside = task + 0.1 * (np.array(NAMES) == "speed")
    moved = method.space.encode(point) + (beside - task) @ method.tangent(task, point, unit, BARRIER)
    plain = method.follow(beside, point, unit, BARRIER, 40)
    predicted = method.follow(beside, method.space.decode(moved), unit, BARRIER, 40)
    assert plain.converged and predicted.converged
    assert predicted.iterations < plain.iterations
    assert predicted.cost == pytest.approx(plain.cost, rel=1e-5)


def test_leaves_the_next_run_as_it_was(centred: tuple, problem: GaitProblem) -> None:
    method, point, task, unit = centred
    before = method.follow(task, point, unit, BARRIER, 40)
    method.tangent(task, point, unit, BARRIER)
    after = method.follow(task, point, unit, BARRIER, 40)
    np.testing.assert_array_equal(before.w, after.w)
