"""Predictive control by fatrop: the body's steps against the core's mechanics, and what a controller relies on."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest
from bodies import PLANAR
from cyclic import cyclic_scenario

from gaitflow.clients.body_model import body_states, step_function
from gaitflow.clients.default_gaits import default_motion
from gaitflow.clients.predictive import Predictor
from gaitflow.core.rigid_body import RigidBody
from gaitflow.core.trajectory import Array
from gaitflow.motion import Motion

ORDER = [0, 1, 2, 6, 7, 8, 3, 4, 5, 9, 10, 11]  # of a predicted state in the core's: position, angles, velocity, rates


@pytest.fixture(scope="module")
def predictor(trot: Motion) -> Predictor:
    return Predictor(trot.scenario)


def _moved(body: RigidBody, state: Array, forces: Array, feet: Array, h: float, parts: int = 200) -> Array:
    """The state after h seconds, by many small midpoint steps with the core's own formulas."""
    at = state[ORDER]
    for _ in range(parts):
        middle = at + h / parts / 2 * body.rate(at, feet, forces)
        at = at + h / parts * body.rate(middle, feet, forces)
    return at[np.argsort(ORDER)]


@pytest.mark.parametrize("seed", range(5))
def test_a_step_is_the_mechanics_of_the_core(trot: Motion, seed: int) -> None:
    rng, h = np.random.default_rng(seed), 0.01
    body = RigidBody.of(trot.scenario["robot"], trot.task)
    state = np.concatenate([rng.normal(0, [0.1, 0.1, 0.5]), rng.normal(0, 0.5, 9)])
    forces, feet = rng.normal(0, 80, (4, 3)), rng.normal(0, 0.4, (4, 3))
    step = step_function(body.inertia, 4)
    after = np.array(step(state, forces.ravel(), feet.ravel(), body.gravity, body.mass, h)).ravel()
    np.testing.assert_allclose(after, _moved(body, state, forces, feet, h), atol=2e-6)


def test_states_of_a_motion_are_its_angles(planned: Motion) -> None:
    knots = planned.trajectory
    found = body_states(planned.sample(knots.times[:-1]))
    body = RigidBody.of(planned.scenario["robot"], planned.task)
    _, angles, _, omega = body.split(knots.base[:-1])
    np.testing.assert_allclose(found[:, 6:9], angles, atol=1e-6)
    np.testing.assert_allclose(found[:, 9:], omega, atol=1e-6)


@pytest.mark.parametrize("which", ["planned", "trot"])
@pytest.mark.parametrize("start", ["motion", "cold"])
def test_the_prediction_is_a_motion_of_the_body(
    predictor: Predictor, which: str, start: Any, request: pytest.FixtureRequest
) -> None:
    motion: Motion = request.getfixturevalue(which)
    found = predictor.predict(motion, since=0.13, start=start)
    assert found.ready and found.iterations <= 20
    robot, h = motion.scenario["robot"], found.times[1] - found.times[0]
    body, seen = RigidBody.of(robot, motion.task), motion.sample((found.times[:-1] + found.times[1:]) / 2)
    step = step_function(body.inertia, 4)
    for k, forces in enumerate(found.forces):
        after = step(found.states[k], forces.ravel(), seen.feet[k].ravel(), body.gravity, body.mass, h)
        np.testing.assert_allclose(np.array(after).ravel(), found.states[k + 1], atol=1e-3)
    assert (np.abs(found.forces[..., :2]) <= motion.task["friction"] * found.forces[..., 2:] + 0.5).all()
    assert (found.forces[..., 2] <= robot["max_force"] + 0.5).all()
    assert (found.forces[~seen.contact] == 0).all()
    np.testing.assert_allclose(found.states[0], body_states(motion.of_mass().sample([0.13]))[0], atol=1e-6)
    way = found.states[-1, 0] - found.states[0, 0]
    assert way == pytest.approx(motion.task.speed * motion.period, abs=0.03)


def test_both_starts_lead_to_one_cost(predictor: Predictor, planned: Motion) -> None:
    costs = [predictor.predict(planned, start=start).cost for start in ("motion", "cold")]
    assert costs[0] == pytest.approx(costs[1], rel=0.02)


def test_a_pushed_body_is_brought_back_step_by_step(predictor: Predictor, trot: Motion) -> None:
    body, times = RigidBody.of(trot.scenario["robot"], trot.task), np.arange(40) * 0.025
    step = step_function(body.inertia, 4)
    state = body_states(trot.of_mass().sample([0.0]))[0]
    state[4] += 0.3  # m/s to the left
    sideways = []
    for now in times:
        found = predictor.predict(trot, since=float(now), state=state)
        assert found.ready
        feet = trot.at(float(now) + 0.0125).feet
        state = np.array(step(state, found.forces[0].ravel(), feet.ravel(), body.gravity, body.mass, 0.025)).ravel()
        sideways.append(state[4])
    assert max(np.abs(sideways[-8:])) < 0.1
    assert abs(state[2] - body.default_feet[0, 2] * -1) < 0.05
    assert np.abs(state[6:9]).max() < 0.2


def test_gaits_on_a_slope_with_a_load_are_predicted_too(predictor: Predictor, trot: Motion) -> None:
    task = trot.task.replaced(slope=8.0, payload=5.0)
    found = predictor.predict(default_motion(trot.scenario, "trot", task, 0.6))
    assert found.ready
    mean = found.forces.sum(axis=1).mean(axis=0)
    weight = (trot.scenario["robot"]["mass"] + 5.0) * 9.81
    np.testing.assert_allclose(mean, [weight * np.sin(np.radians(8)), 0, weight * np.cos(np.radians(8))], atol=30)


def test_what_cannot_be_is_refused_in_one_line(predictor: Predictor, trot: Motion) -> None:
    heavier = trot.scenario | {"robot": trot.scenario["robot"] | {"mass": 40.0}}
    other = default_motion(heavier, "trot", trot.task, 0.5)
    cases = [
        (lambda: Predictor(cyclic_scenario(PLANAR | {"name": "two legs"})), "plane"),
        (lambda: Predictor(trot.scenario, intervals=1), "intervals = 1"),
        (lambda: predictor.predict(other), "built for 'anymal'"),
        (lambda: predictor.predict(trot, start="warm"), "'motion' or 'cold'"),  # type: ignore[arg-type]
        (lambda: predictor.predict(trot, since=np.inf), "since = inf"),
        (lambda: predictor.predict(trot, state=np.zeros(6)), "12 finite numbers"),
    ]
    for asked, said in cases:
        with pytest.raises(ValueError, match=said) as error:
            asked()
        assert "\n" not in str(error.value)


def test_without_casadi_one_line_says_what_to_install(trot: Motion, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "casadi", None)
    with pytest.raises(ImportError, match=r'pip install "gaitflow\[clients\]"') as error:
        Predictor(trot.scenario)
    assert "\n" not in str(error.value)
