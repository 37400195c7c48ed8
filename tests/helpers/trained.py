"""Small classifiers of every kind, trained and converted as the published ones are."""

from __future__ import annotations

from functools import cache

import numpy as np

from gaitflow.config.scenario import Learning
from gaitflow.learn.classifier import GaitClassifier, frequencies_of
from gaitflow.learn.export_onnx import to_onnx_bytes
from gaitflow.learn.methods import methods

NAMES = ("mlp", "forest", "svm", "knn")
LEARNING = Learning(folds=2, hidden_layers=((12, 8, 6),), learning_rates=(1e-2,), max_epochs=100)
LOW, HIGH = (0.1, 0.4, -20.0), (2.3, 1.6, 20.0)


def grid_tasks(axes: int) -> np.ndarray:
    """A grid [10 * 6 * 5, axes], or [10 * 6, 2]: known tasks that are equally far from many others."""
    values = [np.linspace(low, high, n) for low, high, n in zip(LOW, HIGH, (10, 6, 5), strict=True)][:axes]
    return np.stack(np.meshgrid(*values), axis=-1).reshape(-1, axes).astype(np.float32)


@cache
def fitted(name: str, gaits: int, axes: int = 2) -> bytes:
    """A classifier of a method as ONNX; borders between the gaits run across the axes."""
    tasks = grid_tasks(axes)
    score = tasks[:, 0] - 0.5 * tasks[:, 1] + 0.2 * np.sin(5 * tasks[:, -1])
    y = np.digitize(score, np.quantile(score, np.arange(1, gaits) / gaits)).astype(np.int64)
    assert set(y) == set(range(gaits))
    method = next(method for method in methods(LEARNING, axes, gaits, 30) if method.name == name)
    labels = tuple("abcdefgh"[:gaits])
    return to_onnx_bytes(GaitClassifier(name, labels, method.pipeline.fit(tasks, y), frequencies_of(y, gaits), 1.7))
