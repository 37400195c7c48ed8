from __future__ import annotations

import numpy as np
import pytest
from tasks_at import at

from gaitflow.config.scenario import Scenario
from gaitflow.core.check import violations
from gaitflow.core.layout import GRAVITY, Layout
from gaitflow.search import starts

SPEED, CYCLE = 0.7, 0.6
TASK = at(SPEED, CYCLE)


@pytest.fixture(params=["effort", "anymal"])
def either(request: pytest.FixtureRequest) -> Scenario:
    scenario: Scenario = request.getfixturevalue(request.param)
    return scenario


def test_the_nominal_start_glides_over_its_default_feet(either: Scenario) -> None:
    """All that it breaks is that stance feet move: it does the task in balance, level, within every limit."""
    layout = Layout.of(either.as_data())
    trajectory = layout.unpack(starts.nominal(either.robot, layout, TASK), CYCLE)
    found = violations(either.as_data(), trajectory, TASK, "/".join(["1111"] * layout.legs))
    slip = SPEED * CYCLE / layout.steps
    assert found.pop("slip in stance") == pytest.approx(slip)
    # Default feet are not all at one distance from the base, so the shares of the weight leave a small moment.
    assert found.pop("dynamics") < 0.01
    assert max(found.values()) < 1e-12
    np.testing.assert_allclose(trajectory.forces[..., -1].sum(axis=1), either.robot.mass * GRAVITY)


def test_random_starts_repeat_with_their_seed(either: Scenario) -> None:
    layout = Layout.of(either.as_data())
    one, same, other = (starts.random(either.robot, layout, TASK, np.random.default_rng(seed)) for seed in (3, 3, 4))
    np.testing.assert_array_equal(one, same)
    assert (one != other).mean() > 0.9


def test_random_starts_are_physical(either: Scenario) -> None:
    layout, robot = Layout.of(either.as_data()), either.robot
    for seed in range(20):
        w = starts.random(robot, layout, TASK, np.random.default_rng(seed))
        trajectory = layout.unpack(w, CYCLE)
        found = violations(either.as_data(), trajectory, TASK, "/".join(["1111"] * layout.legs))
        for kind in ("cycle", "penetration", "unilaterality", "force limit", "foot speed", "tilt", "clock"):
            assert found[kind] < 1e-12, kind
        assert (trajectory.durations > 0).all()


def test_seeds_depend_on_their_parts_alone() -> None:
    assert starts.seed_of(0, "01/10", 0.5) == starts.seed_of(0, "01/10", 0.5) < 2**64
    assert len({starts.seed_of(seed, text) for seed in range(10) for text in ("01/10", "10/01")}) == 20
