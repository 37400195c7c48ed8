"""The gait map as a planner uses it: ask which gait a task takes, and have it refined into a motion."""

from __future__ import annotations

import math
import threading
import time
from numbers import Real
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gaitflow.runtime.choice import Choice, Choices
from gaitflow.runtime.classifier import Classifier
from gaitflow.runtime.errors import OutOfDomain
from gaitflow.runtime.files import CLASSIFIER, WARM_STARTS, read_checked
from gaitflow.runtime.manifest import Gait, Manifest, read_manifest
from gaitflow.runtime.plan import Plan, refine_ranked
from gaitflow.runtime.refine import Refiner
from gaitflow.runtime.tensors import GaitTensors, WarmStart, parse_tensors, warm_start
from gaitflow.runtime.versions import resolve


class GaitMap:
    """A published map from task (speed m/s, cycle duration s) to gait. Build it with `GaitMap.load`.

    Immutable and safe to use from many threads; plans of one process are made one at a time.
    """

    def __init__(self, folder: Path, manifest: Manifest, classifier: Classifier, tensors: GaitTensors) -> None:
        self._folder = folder
        self._manifest = manifest
        self._classifier = classifier
        self._tensors = tensors
        self._names = tuple(gait.name for gait in manifest.gaits)
        self._building = threading.Lock()
        self._refiner: Refiner | None = None

    @classmethod
    def load(cls, path: str | PathLike[str]) -> GaitMap:
        """Load `models/<scenario>/<version>`, or the newest version in `models/<scenario>`.

        The digests of the classifier and the warm starts are checked; the problem's is when the first plan is made.
        Raises ArtifactError that names the file and what is wrong with it.
        """
        folder = resolve(Path(path))
        manifest = read_manifest(folder)
        gaits, files = len(manifest.gaits), manifest.files
        classifier = Classifier(read_checked(folder, CLASSIFIER, files[CLASSIFIER]), gaits, str(folder / CLASSIFIER))
        content = read_checked(folder, WARM_STARTS, files[WARM_STARTS])
        tensors = parse_tensors(content, gaits, manifest.layout, str(folder / WARM_STARTS))
        return cls(folder, manifest, classifier, tensors)

    @property
    def manifest(self) -> Manifest:
        """What the artifact says of itself: scenario, version, domain, metrics."""
        return self._manifest

    @property
    def gaits(self) -> tuple[Gait, ...]:
        """The gaits that the map chooses from, in the order of `Choices.index`."""
        return self._manifest.gaits

    def select(self, speed: float, cycle_duration: float) -> Choice:
        """The gait for one task (m/s, s). Raises ValueError for an argument that is no finite number."""
        speed, cycle_duration = _finite("speed", speed), _finite("cycle_duration", cycle_duration)
        if not self._manifest.domain.contains(speed, cycle_duration):
            return Choice(speed, cycle_duration, False, None, None, 0.0, (), self._warm_start)
        probabilities = self._probabilities(speed, cycle_duration)
        names = self._names
        ranked = tuple([(names[index], probabilities[index]) for index in _ranking(probabilities)])
        gait, probability = ranked[0]
        pattern = self._manifest.gaits[names.index(gait)].pattern
        return Choice(speed, cycle_duration, True, gait, pattern, probability, ranked, self._warm_start)

    def select_many(self, speeds: ArrayLike, cycle_durations: ArrayLike) -> Choices:
        """The gaits for arrays of tasks (m/s, s) that broadcast against each other.

        Raises ValueError for a value that is no finite number and for shapes that do not broadcast.
        """
        v, t = np.broadcast_arrays(_all_finite("speeds", speeds), _all_finite("cycle_durations", cycle_durations))
        inside = self._manifest.domain.contains_many(v, t)
        index = np.full(v.shape, -1, dtype=np.intp)
        probability = np.zeros(v.shape)
        if inside.any():
            rows = self._classifier(np.stack([v[inside], t[inside]], axis=1).astype(np.float32))
            index[inside] = rows.argmax(axis=1)
            probability[inside] = rows.max(axis=1)
        gaits = np.empty(v.shape, dtype=object)
        gaits[...] = np.array([*self._names, None], dtype=object)[index]
        return Choices(gaits, index, probability, inside)

    def plan(self, speed: float, cycle_duration: float, top: int = 3) -> Plan:
        """A motion for one task (m/s, s), refined from the warm start of the likeliest gait; needs gaitflow[solve].

        If that gait does not refine to a feasible motion the next is tried, `top` gaits at most, and the plan says so.
        Raises OutOfDomain outside the map's domain, ValueError for an argument that is no finite number, ImportError
        without CasADi, ArtifactError when the artifact's problem is damaged.
        """
        started = time.perf_counter()
        speed, cycle_duration = _finite("speed", speed), _finite("cycle_duration", cycle_duration)
        if isinstance(top, bool) or not isinstance(top, int) or top < 1:
            raise ValueError(f"top = {top!r}: must be a number of gaits to try, 1 or more")
        domain = self._manifest.domain
        if not domain.contains(speed, cycle_duration):
            raise OutOfDomain(domain.explain(speed, cycle_duration))
        probabilities = self._probabilities(speed, cycle_duration)
        ranked = [(i, self._manifest.gaits[i], probabilities[i]) for i in _ranking(probabilities)[:top]]
        return refine_ranked(self._load_refiner(), ranked, speed, cycle_duration, started)

    def _probabilities(self, speed: float, cycle_duration: float) -> list[float]:
        task = np.array([[speed, cycle_duration]], dtype=np.float32)
        probabilities: list[float] = self._classifier(task)[0].tolist()
        return probabilities

    def _load_refiner(self) -> Refiner:
        with self._building:
            if self._refiner is None:
                self._refiner = Refiner(self._folder, self._manifest, self._tensors)
            return self._refiner

    def _warm_start(self, gait: str, cycle_duration: float) -> WarmStart:
        index = self._names.index(gait)
        pattern = self._manifest.gaits[index].pattern
        return warm_start(self._tensors, self._manifest.layout, index, gait, pattern, cycle_duration)


def _ranking(probabilities: list[float]) -> list[int]:
    """Indices from the likeliest on; equal ones keep their order."""
    return sorted(range(len(probabilities)), key=probabilities.__getitem__, reverse=True)


def _finite(name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError(f"{name} = {value!r}: must be a finite number")
    try:
        number = float(value)
    except OverflowError:  # an integer beyond every float
        number = math.inf
    if not math.isfinite(number):
        raise ValueError(f"{name} = {number}: must be a finite number")
    return number


def _all_finite(name: str, values: ArrayLike) -> NDArray[np.float64]:
    array = np.asarray(values)
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name}: must hold finite numbers, found {array.dtype}")
    numbers = array.astype(np.float64)
    if not np.isfinite(numbers).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(numbers))[0])
        raise ValueError(f"{name}{list(where)} = {numbers[where]}: must be a finite number")
    return numbers
