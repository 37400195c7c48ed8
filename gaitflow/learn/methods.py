"""The methods that compete for a map, with the hyper-parameters that cross-validation chooses from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sklearn.pipeline import Pipeline
from sklearn.preprocessing import StandardScaler

from gaitflow.config.scenario import Learning
from gaitflow.learn.baselines import nearest_neighbours, random_forest, support_vectors
from gaitflow.learn.mirror import MirrorImages

MLP = "mlp"  # the paper's method
PREFIX = "classify__"  # of the classifier's parameters in the pipeline


@dataclass(frozen=True)
class Method:
    """A pipeline that standardises raw tasks [n, axes] and classifies them; values to try for each parameter."""

    name: str
    pipeline: Pipeline
    grid: Mapping[str, list[Any]]


def methods(
    learning: Learning, axes: int, classes: int, smallest_fit: int, images: MirrorImages | None = None
) -> tuple[Method, ...]:
    """Those that `learning` names of perceptron, SVM, random forest and neighbours; who answers fastest comes first.

    `axes` is how many inputs they have, `smallest_fit` the least number of tasks that one of them is fitted to. Values
    that regularise most come first: the search takes the first of those that do equally well. With `images` the
    perceptron answers alike to the left and to the right; the other methods do so as far as their tasks teach them.
    """
    neighbours = [k for k in (5, 3, 7, 1) if k <= smallest_fit]
    forest = random_forest(learning.seed)
    of_scikit_learn = (
        _method("svm", support_vectors(), {"estimator__C": [1.0, 10.0, 100.0], "estimator__gamma": [0.5, 1.0, 2.0]}),
        _method("forest", forest, {"min_samples_leaf": [3, 1], "max_features": sorted({1, axes})}),
        _method("knn", nearest_neighbours(), {"n_neighbors": neighbours}),
    )
    asked = tuple(method for method in of_scikit_learn if method.name in learning.methods)
    return (_mlp(learning, axes, classes, images), *asked) if MLP in learning.methods else asked


def _mlp(learning: Learning, axes: int, classes: int, images: MirrorImages | None) -> Method:
    from gaitflow.learn.mlp import perceptron  # loads PyTorch, which nothing else needs

    grid: dict[str, list[Any]] = {
        "module__hidden": list(learning.hidden_layers),
        "lr": list(learning.learning_rates),
        "optimizer__weight_decay": sorted(learning.weight_decays, reverse=True),
    }
    mlp = perceptron(axes, classes, learning.hidden_layers[0], learning.max_epochs, learning.seed, images)
    return _method(MLP, mlp, grid)


def _method(name: str, classifier: Any, grid: Mapping[str, list[Any]]) -> Method:
    pipeline = Pipeline([("scale", StandardScaler()), ("classify", classifier)])
    return Method(name, pipeline, {PREFIX + key: values for key, values in grid.items()})
