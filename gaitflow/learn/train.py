"""From labels to the classifier that is published: compete, judge, choose, export."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pandas as pd
from sklearn.dummy import DummyClassifier
from sklearn.metrics import confusion_matrix
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from gaitflow.config.scenario import Learning
from gaitflow.learn.classifier import CannotTrain, Floats, GaitClassifier, Integers
from gaitflow.learn.cross_validation import CrossValidated, cross_validate, refit, stratified_splits
from gaitflow.learn.evaluate import RULE, Quality, choose, judge
from gaitflow.learn.export_onnx import to_onnx_bytes
from gaitflow.learn.methods import methods
from gaitflow.learn.nodes import NodeLabels

CONSTANT = "constant"


@dataclass(frozen=True)
class Competitor:
    """A row of the table of methods."""

    method: str
    parameters: dict[str, Any]  # hyper-parameters that the search chose
    temperature: float  # that calibrates its probabilities
    log_loss_raw: float  # on the folds, before calibration
    log_loss: float  # and after
    cross_validation: Quality
    held_out: Quality


@dataclass(frozen=True)
class Published:
    """The winner as it is published, fitted to the nodes of an atlas, too; without any as it was judged."""

    nodes: int
    temperature: float
    log_loss: float  # calibrated, on folds of whole cells of the grid
    held_out: Quality


@dataclass(frozen=True)
class Training:
    """The published classifier and how it was chosen.

    `classes` [C] names the columns of `onnx`'s output and the rows (label) and columns (pick) of `confusion`, which
    counts the tasks of the test folds. `remarks` say what a reader of the numbers must know.
    """

    classes: tuple[str, ...]
    method: str
    onnx: bytes
    competitors: tuple[Competitor, ...]
    confusion: tuple[tuple[int, ...], ...]
    tasks_per_gait: tuple[int, ...]
    folds: int
    remarks: tuple[str, ...]
    published: Published

    @property
    def winner(self) -> Competitor:
        """The row of the chosen method."""
        return next(row for row in self.competitors if row.method == self.method)

    def as_data(self) -> dict[str, Any]:
        """Plain JSON data, all but the model itself; numbers that do not exist are null."""
        data = {key: value for key, value in asdict(self).items() if key != "onnx"}
        return _plain(data | {"rule": RULE})


def train(
    labels: pd.DataFrame,
    costs: pd.DataFrame,
    learning: Learning,
    constant: bool = False,
    nodes: tuple[NodeLabels, Sequence[str]] | None = None,
) -> Training:
    """Train all methods on the grid tasks that have a label and choose one by RULE; held-out tasks only report.

    `labels` and `costs` are the frames of `gaitflow.dataset.labels`. The winner is then fitted once more, to the
    `nodes` of an atlas and its gaits' names as well: they take no part in choosing. Equal arguments give equal bytes.
    Raises CannotTrain when no grid task is feasible, when all have one gait (unless `constant`: then the map is that
    gait), or when no gait has two tasks.
    """
    solved = labels[labels["status"] == "solved"]
    grid, held_out = solved[solved["split"] == "grid"], solved[solved["split"] == "held_out"]
    if grid.empty:
        raise CannotTrain(
            f"none of the {int((labels['split'] == 'grid').sum())} tasks of the grid has a feasible gait: there is no "
            "map to learn; change the grid, the robot or the terrain"
        )
    classes = tuple(sorted(grid["label"].unique()))
    if len(classes) == 1:
        if not constant:
            raise CannotTrain(
                f"all {len(grid)} feasible tasks have the gait {classes[0]!r}: no classifier can be trained; "
                "widen the grid, or publish the constant map with --constant"
            )
        return _constant_map(classes, grid, held_out, costs)
    tasks = _inputs(grid)
    y = np.searchsorted(np.array(classes, dtype=object), grid["label"].to_numpy(dtype=object)).astype(np.int64)
    splits, remarks = stratified_splits(y, classes, learning.folds, learning.seed)
    found = [
        cross_validate(method, tasks, y, classes, splits)
        for method in methods(learning, len(classes), min(len(fit) for fit, _ in splits))
    ]
    competitors = tuple(_judged(one, grid, held_out, costs) for one in found)
    chosen = choose({row.method: row.cross_validation for row in competitors}, learning.tie_tolerance)
    best = next(one for one in found if one.classifier.method == chosen)
    final, log_loss_final, used = best.classifier, best.log_loss, 0
    if nodes is not None:
        more, more_y, cells = _of_classes(*nodes, classes)
        used = len(more)
        if used:
            final, log_loss_final = refit(best.classifier, (tasks, y), (more, more_y), cells, len(splits))
    confusion = confusion_matrix(y[best.tested], best.probabilities.argmax(axis=1), labels=range(len(classes)))
    return Training(
        classes=classes,
        method=chosen,
        onnx=to_onnx_bytes(final),
        competitors=competitors,
        confusion=tuple(tuple(int(count) for count in row) for row in confusion),
        tasks_per_gait=tuple(int(count) for count in np.bincount(y)),
        folds=len(splits),
        remarks=tuple(remarks),
        published=Published(used, final.temperature, log_loss_final, _held_out_quality(final, held_out, costs)),
    )


def _of_classes(nodes: NodeLabels, gaits: Sequence[str], classes: tuple[str, ...]) -> tuple[Floats, Integers, Integers]:
    """Tasks, places in `classes` and cells of the nodes whose gait is one of them."""
    place = np.array([classes.index(gait) if gait in classes else -1 for gait in gaits], dtype=np.int64)[nodes.gaits]
    return nodes.tasks[place >= 0], place[place >= 0], nodes.cells[place >= 0]


def _judged(one: CrossValidated, grid: pd.DataFrame, held_out: pd.DataFrame, costs: pd.DataFrame) -> Competitor:
    classes = one.classifier.classes
    return Competitor(
        method=one.classifier.method,
        parameters=one.parameters,
        temperature=one.classifier.temperature,
        log_loss_raw=one.log_loss_raw,
        log_loss=one.log_loss,
        cross_validation=judge(one.probabilities, classes, grid.iloc[one.tested], costs),
        held_out=_held_out_quality(one.classifier, held_out, costs),
    )


def _constant_map(
    classes: tuple[str, ...], grid: pd.DataFrame, held_out: pd.DataFrame, costs: pd.DataFrame
) -> Training:
    pipeline = make_pipeline(StandardScaler(), DummyClassifier()).fit(_inputs(grid), np.zeros(len(grid), int))
    classifier = GaitClassifier(CONSTANT, classes, pipeline, frequencies=(1.0,))
    on_grid = judge(classifier.probabilities(_inputs(grid)), classes, grid, costs)
    held_out_quality = _held_out_quality(classifier, held_out, costs)
    return Training(
        classes=classes,
        method=CONSTANT,
        onnx=to_onnx_bytes(classifier),
        competitors=(Competitor(CONSTANT, {}, 1.0, 0.0, 0.0, on_grid, held_out_quality),),
        confusion=((len(grid),),),
        tasks_per_gait=(len(grid),),
        folds=0,
        remarks=("one gait at every feasible task of the grid: nothing was learnt, and nothing cross-validated",),
        published=Published(0, 1.0, 0.0, held_out_quality),
    )


def _held_out_quality(classifier: GaitClassifier, held_out: pd.DataFrame, costs: pd.DataFrame) -> Quality:
    if held_out.empty:
        return judge(np.empty((0, len(classifier.classes))), classifier.classes, held_out, costs)
    return judge(classifier.probabilities(_inputs(held_out)), classifier.classes, held_out, costs)


def _inputs(labels: pd.DataFrame) -> Floats:
    return labels[["speed", "cycle_duration"]].to_numpy(dtype=np.float32)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
