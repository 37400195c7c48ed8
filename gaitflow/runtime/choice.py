"""What the map says about tasks, before any optimisation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gaitflow.runtime.left_out import ChosenValue
from gaitflow.runtime.tensors import WarmStart


@dataclass(frozen=True, slots=True)
class Choice:
    """The gait for one task: `task` has speed [m/s], cycle_duration [s] and the map's other ranged axes.

    `gait` is the name of the gait that the atlas predicts to cost least, over more than three axes least over its
    probability; where the atlas knows none, it is the classifier's likeliest. `pattern` has its contacts: a row of
    digits a leg, 0 swing and 1 stance, joined by "/". `probability` is the classifier's for this gait, calibrated.
    `ranked` has all gaits with their probabilities, in the order in which `plan` tries them: by that cost, then those
    that the atlas does not know there by probability.
    `chosen` describes the value that was left to the map, and is None when all were given.

    Outside the map's domain `in_domain` is False. Then `gait` and `pattern` are None, `probability` is 0 and `ranked`
    is empty, unless an answer was asked for with `beyond`.
    """

    task: Mapping[str, float]
    in_domain: bool
    gait: str | None
    pattern: str | None
    probability: float
    ranked: tuple[tuple[str, float], ...]
    _warm_start: Callable[[str, Mapping[str, float]], WarmStart] = field(repr=False, compare=False)
    _distance: Callable[[Mapping[str, float]], float] = field(repr=False, compare=False)
    chosen: ChosenValue | None = None

    @property
    def speed(self) -> float:
        """v [m/s]."""
        return self.task["speed"]

    @property
    def cycle_duration(self) -> float:
        """T [s]."""
        return self.task["cycle_duration"]

    @property
    def warm_start(self) -> WarmStart | None:
        """Where to start an optimiser for this gait and task, predicted by the atlas; computed on each call.

        It is the mean of the gait's region where the atlas does not know the gait, and None without a gait.
        """
        return None if self.gait is None else self._warm_start(self.gait, self.task)

    @property
    def distance(self) -> float:
        """Distance to the nearest task that the map was trained on, in steps of its grid; between four at most 0.71."""
        return self._distance(self.task)


@dataclass(frozen=True)
class Choices:
    """The gaits for arrays of tasks; every array has the shape of the broadcast arguments.

    gaits: names, None outside the domain; index: place of the gait in `GaitMap.gaits`, -1 outside; probability: the
    classifier's, 0 outside; in_domain: whether the map answers for the task.
    """

    gaits: NDArray[np.object_]
    index: NDArray[np.intp]
    probability: NDArray[np.float64]
    in_domain: NDArray[np.bool_]
