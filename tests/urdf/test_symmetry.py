"""The nearest body that is its own mirror image."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitflow.config.file import ConfigError
from gaitflow.urdf.symmetry import MIRROR, mirror_pairs, symmetrised

NAMES = ("LF", "RF", "LH", "RH")
FEET = np.array([[0.4, 0.2, -0.5], [0.4, -0.2, -0.5], [-0.3, 0.2, -0.5], [-0.3, -0.2, -0.5]])
INERTIA = np.array([[1.0, 0.01, 0.1], [0.01, 2.0, -0.02], [0.1, -0.02, 2.2]])
SWAP = [1, 0, 3, 2]


@given(st.lists(st.floats(-0.01, 0.01), min_size=12, max_size=12))
def test_the_result_is_exactly_its_own_image(noise: list[float]) -> None:
    feet = FEET + np.reshape(noise, (4, 3))
    body = symmetrised(feet, INERTIA, NAMES)
    np.testing.assert_array_equal(body.feet, body.feet[SWAP] * MIRROR)
    np.testing.assert_array_equal(body.inertia, body.inertia * np.outer(MIRROR, MIRROR))
    assert body.pairs == ((0, 1), (2, 3))
    assert np.linalg.norm(body.feet - feet, axis=1).max() == body.foot_offset <= np.sqrt(3) * 0.01


def test_what_was_off_is_said() -> None:
    feet = FEET.copy()
    feet[0, 1] += 0.004  # the pair's mean is 2 mm from each
    body = symmetrised(feet, INERTIA, NAMES)
    assert body.foot_offset == pytest.approx(0.002)
    assert body.products == (0.01, -0.02)
    np.testing.assert_allclose(body.feet[:2, 1], [0.202, -0.202])
    assert body.inertia[0, 2] == 0.1


def test_what_is_symmetric_stays_to_the_last_bit() -> None:
    inertia = np.diag([1.0, 2.0, 2.2])
    body = symmetrised(FEET, inertia, NAMES)
    np.testing.assert_array_equal(body.feet, FEET)
    np.testing.assert_array_equal(body.inertia, inertia)
    assert body.foot_offset == 0


def test_the_left_leg_comes_first() -> None:
    assert mirror_pairs(FEET[[1, 0, 3, 2]]) == ((1, 0), (3, 2))


def test_a_leg_in_the_middle_is_in_no_pair() -> None:
    feet = np.vstack([FEET[:2], [[-0.4, 0.01, -0.5]]])
    body = symmetrised(feet, INERTIA, ("L", "R", "T"))
    assert body.pairs == ((0, 1),)
    np.testing.assert_array_equal(body.feet[2], [-0.4, 0.0, -0.5])


def test_a_foot_too_far_from_its_partners_image() -> None:
    feet = FEET.copy()
    feet[3, 2] += 0.1
    with pytest.raises(ConfigError, match=r"leg LH: its foot is 50\.0 mm from .*, more than 5% of its distance"):
        symmetrised(feet, INERTIA, NAMES)


def test_feet_without_pairs() -> None:
    feet = FEET.copy()
    feet[[1, 3]] = [[0.3, 0.2, -0.5], [0.2, 0.2, -0.5]]
    with pytest.raises(ConfigError, match="--pose"):
        symmetrised(feet, INERTIA, NAMES)


@pytest.mark.parametrize(("at", "said"), [((0, 1), "Ixy = 0.2 "), ((1, 2), "Iyz = 0.2 ")])
def test_a_lopsided_inertia(at: tuple[int, int], said: str) -> None:
    inertia = INERTIA.copy()
    inertia[at] = inertia[at[::-1]] = 0.2
    with pytest.raises(ConfigError, match=said):
        symmetrised(FEET, inertia, NAMES)
