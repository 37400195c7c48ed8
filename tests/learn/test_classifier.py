"""Calibration by one temperature."""

from __future__ import annotations

import numpy as np
import pytest

from gaitflow.learn.classifier import TEMPERATURES, calibrated, fit_temperature, frequencies_of, log_loss


def test_the_temperature_that_made_the_labels_is_found() -> None:
    random = np.random.default_rng(0)
    scores = random.normal(0, 2, (20_000, 3))
    y = np.array([random.choice(3, p=p) for p in calibrated(scores, 2.5)])
    assert fit_temperature(scores, y) == pytest.approx(2.5, rel=0.05)


@pytest.mark.parametrize(("sign", "expected"), [(1.0, TEMPERATURES[0]), (-1.0, TEMPERATURES[1])])
def test_scores_that_are_all_right_or_all_wrong_stop_at_the_bounds(sign: float, expected: float) -> None:
    y = np.array([0, 1, 0, 1])
    scores = sign * (2.0 * np.eye(2)[y] - 1.0)
    assert fit_temperature(scores, y) == pytest.approx(expected, rel=1e-2)


def test_log_loss_of_even_scores_is_the_log_of_the_number_of_classes() -> None:
    assert log_loss(np.zeros((5, 4)), np.array([0, 1, 2, 3, 0])) == pytest.approx(np.log(4))


def test_frequencies_count_classes_that_do_not_occur() -> None:
    assert frequencies_of(np.array([0, 0, 2, 2]), 4) == (0.5, 0.0, 0.5, 0.0)
