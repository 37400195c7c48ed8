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

from gaitflow.core.errors import OutOfDomain
from gaitflow.core.trajectory import Array
from gaitflow.runtime.atlas import Atlas, parse_atlas
from gaitflow.runtime.choice import Choice, Choices
from gaitflow.runtime.classifier import Classifier
from gaitflow.runtime.files import ATLAS, CLASSIFIER, WARM_STARTS, read_checked
from gaitflow.runtime.manifest import Gait, Manifest, read_manifest
from gaitflow.runtime.plan import Asked, Plan, refine_ranked
from gaitflow.runtime.problem import Problem
from gaitflow.runtime.refine import Candidate, Refiner
from gaitflow.runtime.tensors import GaitTensors, WarmStart, parse_tensors, warm_start
from gaitflow.runtime.versions import resolve

FARTHEST = 1e6  # m/s, s: of a task beyond the domain, what the classifier's float32 can take


class GaitMap:
    """A published map from task (speed m/s, cycle duration s) to gait. Build it with `GaitMap.load`.

    Immutable and safe to use from many threads, each of which gets a solver of its own.
    """

    def __init__(self, folder: Path, manifest: Manifest, classifier: Classifier, tensors: GaitTensors) -> None:
        self._folder = folder
        self._manifest = manifest
        self._classifier = classifier
        self._tensors = tensors
        self._names = tuple(gait.name for gait in manifest.gaits)
        self._building = threading.RLock()
        self._of_thread = threading.local()
        self._loaded_atlas: Atlas | None = None
        self._problem: Problem | None = None

    @classmethod
    def load(cls, path: str | PathLike[str]) -> GaitMap:
        """Load `models/<scenario>/<version>`, or the newest version in `models/<scenario>`.

        The digests of the classifier and the mean starts are checked; the atlas' and the problem's when the first warm
        start is asked for and the first plan is made.
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

    def select(self, speed: float, cycle_duration: float, beyond: bool = False) -> Choice:
        """The gait for one task (m/s, s). Raises ValueError for an argument that is no finite number.

        Outside the map's domain it says nothing, unless `beyond` asks for the classifier's guess all the same.
        """
        speed, cycle_duration = _finite("speed", speed), _finite("cycle_duration", cycle_duration)
        inside = self._manifest.domain.contains(speed, cycle_duration)
        if not inside and (not beyond or cycle_duration <= 0):
            return Choice(speed, cycle_duration, False, None, None, 0.0, (), self._warm_start, self._distance)
        probabilities = self._probabilities(speed, cycle_duration)
        names = self._names
        ranked = tuple([(names[index], probabilities[index]) for index in _ranking(probabilities)])
        gait, probability = ranked[0]
        pattern = self._manifest.gaits[names.index(gait)].pattern
        return Choice(
            speed, cycle_duration, inside, gait, pattern, probability, ranked, self._warm_start, self._distance
        )

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

    def plan(self, speed: float, cycle_duration: float, top: int = 3, beyond: bool = False) -> Plan:
        """A motion for one task (m/s, s), refined from a predicted start; needs gaitflow[solve].

        Tried first is the gait that the atlas predicts to cost least; gaits that it does not know at this task follow
        by their probability. If one does not refine to a feasible motion the next is tried, `top` gaits at most, and
        the plan says so. `beyond` plans outside the map's domain, too: what comes out is checked all the same, and a
        plan that is not feasible says so. Raises OutOfDomain outside the domain otherwise, ValueError for an argument
        that is no finite number, ImportError without CasADi, ArtifactError when a file of the artifact is damaged.
        """
        started = time.perf_counter()
        speed, cycle_duration = _finite("speed", speed), _finite("cycle_duration", cycle_duration)
        if isinstance(top, bool) or not isinstance(top, int) or top < 1:
            raise ValueError(f"top = {top!r}: must be a number of gaits to try, 1 or more")
        domain = self._manifest.domain
        inside = domain.contains(speed, cycle_duration)
        if not inside and (not beyond or cycle_duration <= 0):
            raise OutOfDomain(domain.explain(speed, cycle_duration))
        refiner = self._refiner()
        probabilities = self._probabilities(speed, cycle_duration)
        candidates = self._candidates(probabilities, speed, cycle_duration)[:top]
        ranked = [(each, self._manifest.gaits[each.gait], probabilities[each.gait]) for each in candidates]
        asked = Asked(speed, cycle_duration, inside, domain.distance(speed, cycle_duration), started)
        return refine_ranked(refiner, ranked, asked)

    def mean_start(self, gait: str, cycle_duration: float) -> WarmStart:
        """The paper's warm start of a gait: the mean over its region, scaled to the cycle duration [s].

        Raises ValueError for a gait that the map does not have.
        """
        if gait not in self._names:
            raise ValueError(f"gait = {gait!r}: the map has {', '.join(self._names)}")
        index = self._names.index(gait)
        return self._unpacked(index, self._manifest.gaits[index].pattern, self._tensors.mean(index), cycle_duration)

    def _probabilities(self, speed: float, cycle_duration: float) -> list[float]:
        task = np.clip([[speed, cycle_duration]], -FARTHEST, FARTHEST).astype(np.float32)
        probabilities: list[float] = self._classifier(task)[0].tolist()
        return probabilities

    def _candidates(self, probabilities: list[float], speed: float, cycle_duration: float) -> list[Candidate]:
        """Gaits of known cost, cheapest first, each by its cheapest sheet; then the others, likeliest first."""
        atlas = self._atlas()
        known = [Candidate(atlas.sheets[sheet].gait, sheet) for sheet in atlas.ranked(speed, cycle_duration)]
        gaits = {each.gait for each in known}
        return known + [Candidate(gait, None) for gait in _ranking(probabilities) if gait not in gaits]

    def _refiner(self) -> Refiner:
        refiner: Refiner | None = getattr(self._of_thread, "refiner", None)
        if refiner is None:
            atlas = self._atlas()
            with self._building:
                if self._problem is None:
                    self._problem = Problem(self._folder, self._manifest)
                refiner = Refiner(self._problem, self._manifest, self._tensors, atlas)
            self._of_thread.refiner = refiner
        return refiner

    def _atlas(self) -> Atlas:
        if self._loaded_atlas is None:
            with self._building:
                if self._loaded_atlas is None:
                    self._loaded_atlas = load_atlas(self._folder, self._manifest)
        return self._loaded_atlas

    def _warm_start(self, gait: str, speed: float, cycle_duration: float) -> WarmStart:
        index, atlas = self._names.index(gait), self._atlas()
        own = [sheet for sheet in atlas.ranked(speed, cycle_duration) if atlas.sheets[sheet].gait == index]
        predicted = atlas.predict(own[0], speed, cycle_duration) if own else None
        if predicted is None:
            return self.mean_start(gait, cycle_duration)
        sheet = atlas.sheets[own[0]]
        vectors = sheet.space.join(sheet.space.decode(predicted.point), predicted.cost)
        return self._unpacked(index, sheet.pattern, vectors, cycle_duration)

    def _unpacked(
        self, gait: int, pattern: str, vectors: tuple[Array, Array, Array], cycle_duration: float
    ) -> WarmStart:
        manifest = self._manifest
        return warm_start(
            manifest.layout, self._tensors.scale, manifest.gaits[gait].name, pattern, vectors, cycle_duration
        )

    def _distance(self, speed: float, cycle_duration: float) -> float:
        return self._manifest.domain.distance(speed, cycle_duration)


def load_atlas(folder: Path, manifest: Manifest) -> Atlas:
    """The atlas of the artifact in `folder`, an empty one for a map of before there were any.

    Raises ArtifactError when it is damaged or does not fit the manifest.
    """
    if ATLAS not in manifest.files:
        return Atlas.empty()
    content = read_checked(folder, ATLAS, manifest.files[ATLAS])
    return parse_atlas(content, len(manifest.gaits), manifest.layout, str(folder / ATLAS))


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
