"""Stratified k-fold cross-validation with a search over hyper-parameters, also where some gaits are rare."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from sklearn.base import clone
from sklearn.model_selection import GridSearchCV, GroupKFold, StratifiedKFold

from gaitflow.learn.classifier import (
    CannotTrain,
    Floats,
    GaitClassifier,
    Integers,
    calibrated,
    fit_temperature,
    frequencies_of,
    log_loss,
    scores,
)
from gaitflow.learn.methods import PREFIX, Method

Split = tuple[Integers, Integers]  # indices of the tasks to fit to, and of those to test


@dataclass(frozen=True)
class CrossValidated:
    """A method after cross-validation: the classifier fitted to all tasks, and what its folds said out of sample."""

    classifier: GaitClassifier
    parameters: dict[str, Any]  # the hyper-parameters chosen
    tested: Integers  # [m] tasks that were in a test fold
    probabilities: Floats  # [m, C] calibrated, each from the fit that had not seen the task
    log_loss_raw: float  # of the scores at `tested` before calibration
    log_loss: float  # and after


def stratified_splits(
    y: Integers, classes: Sequence[str], folds: int, seed: int, partners: Integers | None = None
) -> tuple[list[Split], list[str]]:
    """Splits of the tasks with classes y [n] (each of 0..len(classes)-1 occurs), and remarks for the user.

    Every fit knows every class: a gait of a single task is always fitted to and never tested, one of fewer tasks than
    `folds` is missing from some test folds, and there are never more folds than the most common gait has tasks.

    Where tasks have mirror images, `partners` [n] are the numbers of these (`MirrorImages.partners`). A task and its
    image count as one task of both gaits and are tested together, because the one tells the label of the other; tasks
    without an image are always fitted to.
    Raises CannotTrain when there are fewer than two gaits, or none has two tasks.
    """
    images = np.arange(len(y)) if partners is None else partners
    firsts = np.flatnonzero(np.arange(len(y)) <= images)  # the first of each pair
    kinds = np.minimum(y[firsts], y[images[firsts]])
    pairs_of_kind = np.bincount(kinds, minlength=len(classes))
    counts = np.zeros(len(classes), dtype=int)  # of each gait: its tasks, or pairs of which one has it
    for pair in zip(y[firsts], y[images[firsts]], strict=True):
        counts[list(set(pair))] += 1
    if len(classes) < 2 or counts.max() < 2:
        raise CannotTrain(
            f"{len(y)} tasks with {len(classes)} gaits cannot be cross-validated: "
            "at least two gaits are needed, one of them at two tasks; take a finer or wider grid of tasks"
        )
    remarks = []
    singles = [name for name, count in zip(classes, counts, strict=True) if count <= 1]
    rare = [f"{name} ({count})" for name, count in zip(classes, counts, strict=True) if 1 < count < folds]
    if singles:
        remarks.append(f"gaits of a single task, fitted to but never tested: {', '.join(singles)}")
    if rare:
        remarks.append(f"gaits of fewer tasks than the {folds} folds, missing from some of them: {', '.join(rare)}")
    if counts.max() < folds:
        remarks.append(f"{counts.max()} folds instead of {folds}: no gait has more tasks")
    tested = pairs_of_kind[kinds] > 1
    firsts, kinds = firsts[tested], kinds[tested]
    stratified = StratifiedKFold(min(folds, int(counts.max())), shuffle=True, random_state=seed)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "The least populated class", UserWarning)  # said in the remarks
        tests = [test for _, test in stratified.split(np.zeros(len(firsts)), kinds)]
    splits = []
    for each in tests:
        test = np.unique([firsts[each], images[firsts[each]]])
        splits.append((np.setdiff1d(np.arange(len(y)), test), test))
    return splits, remarks


def cross_validate(
    method: Method, tasks: Floats, y: Integers, classes: tuple[str, ...], splits: Sequence[Split]
) -> CrossValidated:
    """Choose the hyper-parameters by mean accuracy over the splits, calibrate on the same, and fit to all tasks.

    tasks [n, axes] raw, y [n] places in `classes`. The folds that chose the hyper-parameters also judge, which
    flatters every method a little; tasks off the grid are what shows by how much.
    """
    tasks = np.asarray(tasks, dtype=np.float32)
    search = GridSearchCV(
        method.pipeline, dict(method.grid), scoring="accuracy", cv=list(splits), n_jobs=1, error_score="raise"
    ).fit(tasks, y)
    out_of_sample = []
    for fit, test in splits:
        pipeline = clone(search.best_estimator_).fit(tasks[fit], y[fit])
        out_of_sample.append(scores(pipeline, tasks[test], frequencies_of(y[fit], len(classes))))
    tested = np.concatenate([test for _, test in splits])
    found = np.concatenate(out_of_sample)
    temperature = fit_temperature(found, y[tested])
    return CrossValidated(
        classifier=GaitClassifier(
            method.name, classes, search.best_estimator_, frequencies_of(y, len(classes)), temperature
        ),
        parameters={key.removeprefix(PREFIX): value for key, value in search.best_params_.items()},
        tested=tested,
        probabilities=calibrated(found, temperature),
        log_loss_raw=log_loss(found, y[tested]),
        log_loss=log_loss(found, y[tested], temperature),
    )


def refit(
    judged: GaitClassifier,
    grid: tuple[Floats, Integers],
    others: tuple[Floats, Integers],
    cells: Integers,
    folds: int,
) -> tuple[GaitClassifier, float]:
    """The classifier with the same settings fitted to the grid's tasks and to others, and its calibrated log loss.

    (tasks [n, axes], y [n]) of each. It is calibrated on folds of whole `cells` [m] of the grid, each predicted by a
    fit to the grid and the others in other cells: a task's neighbours would tell its label. With fewer cells than two
    the temperature stays.
    """
    (tasks, y), (more, more_y) = grid, others
    everything, labels = np.concatenate([tasks, more]), np.concatenate([y, more_y])
    classes, temperature, loss = len(judged.classes), judged.temperature, math.nan
    if len(np.unique(cells)) >= max(2, folds):
        found, true = [], []
        for fit, test in GroupKFold(max(2, folds)).split(more, more_y, cells):
            fitted_y = np.concatenate([y, more_y[fit]])
            pipeline = clone(judged.pipeline).fit(np.concatenate([tasks, more[fit]]), fitted_y)
            found.append(scores(pipeline, more[test], frequencies_of(fitted_y, classes)))
            true.append(more_y[test])
        temperature = fit_temperature(np.concatenate(found), np.concatenate(true))
        loss = log_loss(np.concatenate(found), np.concatenate(true), temperature)
    pipeline = clone(judged.pipeline).fit(everything, labels)
    fitted = GaitClassifier(judged.method, judged.classes, pipeline, frequencies_of(labels, classes), temperature)
    return fitted, loss
