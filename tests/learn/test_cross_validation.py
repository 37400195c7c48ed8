"""Folds of maps with rare gaits, and what a cross-validated method hands back."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from gaitflow.config.scenario import Learning
from gaitflow.learn.classifier import CannotTrain
from gaitflow.learn.cross_validation import cross_validate, stratified_splits
from gaitflow.learn.methods import Method, methods


def test_every_fit_knows_every_gait_and_no_task_is_fitted_and_tested_at_once() -> None:
    y = np.array([0] * 20 + [1] * 6 + [2] * 2 + [3])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        splits, remarks = stratified_splits(y, ("a", "b", "c", "d"), folds=5, seed=0)
    assert len(splits) == 5
    assert all(set(y[fit]) == {0, 1, 2, 3} for fit, _ in splits)
    assert all(set(fit).isdisjoint(test) and len(fit) + len(test) == len(y) for fit, test in splits)
    tested = np.concatenate([test for _, test in splits])
    assert sorted(tested) == list(range(28)), "each task is tested once, but the only one of its gait"
    assert any("never tested: d" in remark for remark in remarks)
    assert any("c (2)" in remark and "b" not in remark.split(":")[1] for remark in remarks)


def test_fewer_tasks_than_folds_give_fewer_folds_and_a_remark() -> None:
    splits, remarks = stratified_splits(np.array([0, 0, 0, 1, 1, 2]), ("a", "b", "c"), folds=5, seed=0)
    assert len(splits) == 3
    assert any("3 folds instead of 5" in remark for remark in remarks)


@pytest.mark.parametrize(("y", "classes"), [([0, 1, 2], ("a", "b", "c")), ([0, 0, 0], ("a",))])
def test_what_cannot_be_split_is_refused(y: list[int], classes: tuple[str, ...]) -> None:
    with pytest.raises(CannotTrain, match=f"{len(y)} tasks with {len(classes)} gaits.*finer or wider grid"):
        stratified_splits(np.array(y), classes, folds=2, seed=0)


def svm(learning: Learning, classes: int) -> Method:
    return next(method for method in methods(learning, 2, classes, 20) if method.name == "svm")


def test_probabilities_come_from_fits_that_had_not_seen_the_task(learning: Learning) -> None:
    """Random labels cannot be foretold: one who had seen them would do far better than the share of the larger."""
    random = np.random.default_rng(1)
    tasks = random.uniform((0.1, 0.4), (2.3, 1.6), (60, 2))
    y = random.permutation([0] * 30 + [1] * 30)
    splits, _ = stratified_splits(y, ("a", "b"), 3, 0)
    found = cross_validate(svm(learning, 2), tasks, y, ("a", "b"), splits)
    assert sorted(found.tested) == list(range(60))
    assert np.mean(found.probabilities.argmax(axis=1) == y[found.tested]) < 0.75


def test_calibration_lowers_the_log_loss_and_keeps_the_ranking(learning: Learning) -> None:
    random = np.random.default_rng(2)
    tasks = random.uniform((0.1, 0.4), (2.3, 1.6), (60, 2))
    y = (tasks[:, 0] + random.normal(0, 0.3, 60) > 1.2).astype(np.int64)
    splits, _ = stratified_splits(y, ("slow", "fast"), 3, 0)
    found = cross_validate(svm(learning, 2), tasks, y, ("slow", "fast"), splits)
    assert found.log_loss < found.log_loss_raw
    assert found.classifier.temperature != pytest.approx(1.0, abs=1e-3)
    truth = found.probabilities[np.arange(60), y[found.tested]]
    assert found.log_loss == pytest.approx(-np.log(truth).mean())
    decision = found.classifier.pipeline.predict(tasks.astype(np.float32))
    np.testing.assert_array_equal(found.classifier.probabilities(tasks).argmax(axis=1), decision)
