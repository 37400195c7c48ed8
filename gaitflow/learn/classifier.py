"""A fitted gait classifier, whatever the method: scores of the gaits at a task, and calibrated probabilities."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.special import log_softmax, softmax
from sklearn.pipeline import Pipeline

Floats = NDArray[np.floating[Any]]
Integers = NDArray[np.int64]

SMOOTHING = 0.01  # weight of the classes' frequencies beside a method's votes, which may be 0
TEMPERATURES = (0.1, 10.0)


class CannotTrain(ValueError):
    """No classifier can be learnt from these labels: the message says why, and what to do instead."""


@dataclass(frozen=True)
class GaitClassifier:
    """A fitted pipeline that standardises raw tasks, and the temperature that calibrates its scores.

    The pipeline knows the gaits as 0..C-1, their places in `classes`; `frequencies` [C] are those it was fitted to.
    """

    method: str
    classes: tuple[str, ...]
    pipeline: Pipeline
    frequencies: tuple[float, ...]
    temperature: float = 1.0

    @property
    def inputs(self) -> int:
        """Number of axes of a task."""
        return int(self.pipeline[0].n_features_in_)

    def probabilities(self, tasks: Floats) -> Floats:
        """Probability of each gait [n, C] at raw tasks [n, axes]."""
        return calibrated(scores(self.pipeline, tasks, self.frequencies), self.temperature)


def frequencies_of(y: Integers, classes: int) -> tuple[float, ...]:
    """Share of each class 0..classes-1 in y [n]."""
    return tuple(float(share) for share in np.bincount(y, minlength=classes) / len(y))


def scores(pipeline: Pipeline, tasks: Floats, frequencies: tuple[float, ...]) -> Floats:
    """Scores [n, C] of a fitted pipeline at raw tasks [n, axes]: logits, decision values, or the log of votes.

    Votes can be 0, whose log is no score: the classes' frequencies [C] are added with a small weight, which also ranks
    the gaits that got no vote.
    """
    tasks = np.asarray(tasks, dtype=np.float32)
    classifier = pipeline[-1]
    if hasattr(classifier, "module_"):  # a network's raw output, without the rounding of softmax and log
        return classifier.forward(pipeline[:-1].transform(tasks)).numpy().astype(float)
    if hasattr(classifier, "decision_function"):
        decision = np.asarray(pipeline.decision_function(tasks))
        return np.stack([-decision, decision], axis=1) if decision.ndim == 1 else decision
    return np.asarray(np.log(pipeline.predict_proba(tasks) + SMOOTHING * np.asarray(frequencies)))


def calibrated(scores: Floats, temperature: float) -> Floats:
    """Probabilities [n, C] of scores [n, C]: softmax(scores / temperature)."""
    return np.asarray(softmax(scores / temperature, axis=1))


def log_loss(scores: Floats, y: Integers, temperature: float = 1.0) -> float:
    """Mean negative log probability of the true classes y [n] under scores [n, C]."""
    return float(-np.mean(log_softmax(scores / temperature, axis=1)[np.arange(len(y)), y]))


def fit_temperature(scores: Floats, y: Integers) -> float:
    """Temperature that minimises the log loss of scores [n, C] at tasks the pipeline was not fitted to.

    One number within TEMPERATURES for all classes, so it never changes a ranking (Guo et al. 2017, "On calibration of
    modern neural networks", section 4.2).
    """
    best = minimize_scalar(
        lambda log_t: log_loss(scores, y, float(np.exp(log_t))), bounds=np.log(TEMPERATURES), method="bounded"
    )
    return float(np.exp(best.x))
