"""Crocoddyl on ANYmal: the problem is the motion's, the start is good, the answer is a motion."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pinocchio
import pytest

from gaitflow.clients.shooting import Shot, shoot
from gaitflow.clients.shooting_problem import shooting_problem
from gaitflow.clients.whole_body import WholeBody
from gaitflow.motion import Motion


@pytest.fixture(scope="module")
def shots(body: WholeBody, planned: Motion, trot: Motion) -> dict[str, Shot]:
    return {
        "plan": shoot(body, planned),
        "cold": shoot(body, planned, start="cold"),
        "trot": shoot(body, trot),
    }


def test_every_start_converges_and_the_plans_is_a_good_one(shots: dict[str, Shot]) -> None:
    assert all(shot.ready for shot in shots.values())
    assert shots["plan"].cost == pytest.approx(shots["cold"].cost, rel=1e-3)
    assert shots["plan"].iterations < shots["cold"].iterations
    assert shots["plan"].iterations <= 10


@pytest.mark.parametrize("name", ["plan", "cold", "trot"])
def test_the_robot_walks_as_commanded(shots: dict[str, Shot], name: str, planned: Motion) -> None:
    shot, task = shots[name], planned.task
    way = shot.base_path[-1] - shot.base_path[0]
    np.testing.assert_allclose(way[:2], [task.speed * 2 * task.cycle_duration, 0.0], atol=0.05)
    assert shot.feet_error < 0.02
    assert shot.times[-1] == pytest.approx(2 * task.cycle_duration)


def test_the_answer_is_a_motion_of_the_robot(body: WholeBody, shots: dict[str, Shot], trot: Motion) -> None:
    shot, model, data = shots["trot"], body.mechanism.model, body.mechanism.data
    stands = trot.sample((shot.times[:-1] + shot.times[1:]) / 2).contact
    h = shot.times[1] - shot.times[0]
    # Crocoddyl integrates velocities first: what it moves by in a step is the velocity at its end.
    v = [
        pinocchio.difference(model, a, b) / h
        for a, b in zip(shot.configurations, shot.configurations[1:], strict=False)
    ]
    for k in range(1, len(v)):
        q = shot.configurations[k]
        jacobians = [
            pinocchio.computeFrameJacobian(model, data, q, foot, pinocchio.LOCAL_WORLD_ALIGNED)[:3]
            for foot, down in zip(body.feet, stands[k], strict=True)
            if down
        ]
        needed = pinocchio.rnea(model, data, q, v[k - 1], (v[k] - v[k - 1]) / h)
        needed[6:] -= shot.torques[k]
        stacked = np.vstack(jacobians).T
        forces = np.linalg.lstsq(stacked, needed, rcond=None)[0]
        np.testing.assert_allclose(stacked @ forces, needed, atol=1e-3)
        assert (forces.reshape(-1, 3)[:, 2] > -5.0).all()


def test_contacts_are_those_in_the_middle_of_each_interval(body: WholeBody, planned: Motion) -> None:
    path = body.along(planned, np.linspace(0.0, planned.period, 31))
    problem = shooting_problem(body, planned, path)
    seen = planned.sample((path.times[:-1] + path.times[1:]) / 2)
    assert problem.T == 30
    np.testing.assert_array_equal(problem.x0, np.concatenate([path.configurations[0], path.velocities[0]]))
    for model, stands, feet in zip(problem.runningModels, seen.contact, seen.feet, strict=True):
        contacts = model.differential.contacts.contacts.todict()
        assert set(contacts) == {f"foot {leg}" for leg in np.flatnonzero(stands)}
        for leg in np.flatnonzero(stands):
            np.testing.assert_allclose(contacts[f"foot {leg}"].contact.reference, feet[leg])


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"dt": 0.0}, "dt = 0"),
        ({"dt": 5.0}, "dt = 5"),
        ({"start": "warm"}, "'motion' or 'cold'"),
        ({"cycles": 0}, "cycles = 0"),
    ],
)
def test_numbers_that_cannot_be_are_refused(body: WholeBody, trot: Motion, wrong: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        shoot(body, trot, **wrong)


def test_without_crocoddyl_one_line_says_what_to_install(
    body: WholeBody, trot: Motion, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "crocoddyl", None)
    with pytest.raises(ImportError, match=r'pip install "gaitflow\[clients\]"') as error:
        shoot(body, trot)
    assert "\n" not in str(error.value)
