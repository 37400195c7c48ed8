"""From labels to the classifier that is published: compete, judge, choose, export."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pandas as pd
from sklearn.dummy import DummyClassifier
from sklearn.metrics import confusion_matrix
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from gaitflow.config.scenario import Learning
from gaitflow.core.domain import Domain
from gaitflow.learn.classifier import CannotTrain, Floats, GaitClassifier, Integers
from gaitflow.learn.cross_validation import CrossValidated, cross_validate, refit, stratified_splits
from gaitflow.learn.evaluate import RULE, Quality, choose, judge, judge_order
from gaitflow.learn.export_onnx import to_onnx_bytes
from gaitflow.learn.from_atlas import atlas_labels, picks
from gaitflow.learn.methods import methods
from gaitflow.learn.mirror import MirrorImages
from gaitflow.runtime.atlas import Atlas

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
class KnownCosts:
    """An atlas, the names of its gaits, and the tasks that it is for."""

    atlas: Atlas
    gaits: tuple[str, ...]
    domain: Domain


@dataclass(frozen=True)
class Published:
    """What is published: the winner, fitted to tasks that the atlas labels, too, and what a map picks by the atlas.

    Without an atlas the classifier is as it was judged, and picks.
    """

    atlas_tasks: int
    temperature: float
    log_loss: float  # calibrated, on folds of whole cells of the grid
    held_out: Quality
    map_held_out: Quality  # of the map's picks: by predicted cost where the atlas knows a gait


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
    axes: Sequence[str],
    learning: Learning,
    constant: bool = False,
    known: KnownCosts | None = None,
    image_of: Mapping[str, str] | None = None,
    tell: Callable[[str], None] = lambda text: None,
) -> Training:
    """Train all methods on the map's tasks that have a label and choose one by RULE; held-out tasks only report.

    `labels` and `costs` are the frames of `gaitflow.dataset.labels`; the classifiers' inputs are the values on `axes`.
    The winner is then fitted once more, to tasks that an atlas over few axes labels as well: they take no part in
    choosing. `image_of` names each gait's mirror image where the tasks of the map have images. `tell` hears what is
    being done. Equal arguments give equal bytes, whatever the order of their rows. Raises CannotTrain when none of them
    is feasible, when all have one gait (unless `constant`: then the map is that gait), or when no gait has two tasks.
    """
    # A sampling has its tasks in another order than the dataset that is published, and trains the same classifier.
    solved = labels[labels["status"] == "solved"].sort_values(list(axes), kind="stable", ignore_index=True)
    grid, held_out = solved[solved["split"] != "held_out"], solved[solved["split"] == "held_out"]
    if grid.empty:
        raise CannotTrain(
            f"none of the {int((labels['split'] != 'held_out').sum())} tasks of the map has a feasible gait: there is "
            "nothing to learn; change the ranges of its axes or the robot"
        )
    classes = tuple(sorted(grid["label"].unique()))
    if len(classes) == 1:
        if not constant:
            raise CannotTrain(
                f"all {len(grid)} feasible tasks have the gait {classes[0]!r}: no classifier can be trained; "
                "widen the ranges of its axes, or publish the constant map with --constant"
            )
        return _constant_map(classes, axes, grid, held_out, costs)
    tasks = _inputs(grid, axes)
    y = np.searchsorted(np.array(classes, dtype=object), grid["label"].to_numpy(dtype=object)).astype(np.int64)
    images = None if image_of is None else MirrorImages.of(axes, classes, image_of)
    partners = None if images is None else images.partners(tasks, y)
    splits, remarks = stratified_splits(y, classes, learning.folds, learning.seed, partners)
    competing = methods(learning, len(axes), len(classes), min(len(fit) for fit, _ in splits), images)
    found = []
    for number, method in enumerate(competing, 1):
        tell(f"classifier {number} of {len(competing)}: {method.name}, {len(splits)} folds of {len(grid)} tasks")
        found.append(cross_validate(method, tasks, y, classes, splits))
    competitors = tuple(_judged(one, axes, grid, held_out, costs) for one in found)
    chosen = choose({row.method: row.cross_validation for row in competitors}, learning.tie_tolerance)
    best = next(one for one in found if one.classifier.method == chosen)
    final, log_loss_final, used = best.classifier, best.log_loss, 0
    # Over more axes nodes lie so far apart that what is predicted between them misleads: fitted to 1,133 such tasks,
    # too, the perceptron of `anymal-omni` named the best gait at 78 % of fresh tasks instead of 82 %.
    if known is not None and not known.atlas.is_wide:
        tell(f"{chosen}, to be published: fitted to what the atlas labels, too")
        more, more_y, cells = _labelled_by(known, classes, learning.tie_tolerance)
        used = len(more)
        if used:
            final, log_loss_final = refit(best.classifier, (tasks, y), (more, more_y), cells, len(splits))
    held_out_quality = _held_out_quality(final, axes, held_out, costs)
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
        published=Published(
            used,
            final.temperature,
            log_loss_final,
            held_out_quality,
            held_out_quality if known is None else _map_quality(final, known, axes, held_out, costs),
        ),
    )


def _labelled_by(
    known: KnownCosts, classes: tuple[str, ...], tie_tolerance: float
) -> tuple[Floats, Integers, Integers]:
    """Tasks, places in `classes` and cells of what an atlas labels with one of the classes."""
    labelled = atlas_labels(known.atlas, known.domain, tie_tolerance)
    places = [classes.index(gait) if gait in classes else -1 for gait in known.gaits]
    place = np.array(places, dtype=np.int64)[labelled.gaits]
    return labelled.tasks[place >= 0], place[place >= 0], labelled.cells[place >= 0]


def _map_quality(
    classifier: GaitClassifier, known: KnownCosts, axes: Sequence[str], held_out: pd.DataFrame, costs: pd.DataFrame
) -> Quality:
    """Of what a map picks: by the atlas, and by the classifier where that knows nothing."""
    classes = classifier.classes
    atlas = known.atlas.of([known.gaits.index(gait) for gait in classes])
    places = _inputs(held_out, axes).astype(float)
    probabilities = classifier.probabilities(places) if len(places) else np.empty((0, len(classes)))
    return judge_order(picks(atlas, places, probabilities), classes, held_out, costs)


def _judged(
    one: CrossValidated, axes: Sequence[str], grid: pd.DataFrame, held_out: pd.DataFrame, costs: pd.DataFrame
) -> Competitor:
    classes = one.classifier.classes
    return Competitor(
        method=one.classifier.method,
        parameters=one.parameters,
        temperature=one.classifier.temperature,
        log_loss_raw=one.log_loss_raw,
        log_loss=one.log_loss,
        cross_validation=judge(one.probabilities, classes, grid.iloc[one.tested], costs),
        held_out=_held_out_quality(one.classifier, axes, held_out, costs),
    )


def _constant_map(
    classes: tuple[str, ...], axes: Sequence[str], grid: pd.DataFrame, held_out: pd.DataFrame, costs: pd.DataFrame
) -> Training:
    pipeline = make_pipeline(StandardScaler(), DummyClassifier()).fit(_inputs(grid, axes), np.zeros(len(grid), int))
    classifier = GaitClassifier(CONSTANT, classes, pipeline, frequencies=(1.0,))
    on_grid = judge(classifier.probabilities(_inputs(grid, axes)), classes, grid, costs)
    held_out_quality = _held_out_quality(classifier, axes, held_out, costs)
    return Training(
        classes=classes,
        method=CONSTANT,
        onnx=to_onnx_bytes(classifier),
        competitors=(Competitor(CONSTANT, {}, 1.0, 0.0, 0.0, on_grid, held_out_quality),),
        confusion=((len(grid),),),
        tasks_per_gait=(len(grid),),
        folds=0,
        remarks=("one gait at every feasible task of the grid: nothing was learnt, and nothing cross-validated",),
        published=Published(0, 1.0, 0.0, held_out_quality, held_out_quality),
    )


def _held_out_quality(
    classifier: GaitClassifier, axes: Sequence[str], held_out: pd.DataFrame, costs: pd.DataFrame
) -> Quality:
    if held_out.empty:
        return judge(np.empty((0, len(classifier.classes))), classifier.classes, held_out, costs)
    return judge(classifier.probabilities(_inputs(held_out, axes)), classifier.classes, held_out, costs)


def _inputs(labels: pd.DataFrame, axes: Sequence[str]) -> Floats:
    return labels[list(axes)].to_numpy(dtype=np.float32)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
