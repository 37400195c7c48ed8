"""Left-right mirror images of tasks and gaits, where a map is its own image: there a classifier should be, too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.dataset.mirror import has_images
from gaitflow.learn.classifier import Floats, Integers
from gaitflow.runtime.sheet_image import signs_of


def images_of_gaits(scenario: Scenario, costs: pd.DataFrame) -> dict[str, str] | None:
    """The name of each gait's image among the gaits of `costs`, the frame of `gaitflow.dataset.labels`.

    None where the images of the map's tasks are not other tasks of it.
    """
    if not has_images(scenario):
        return None
    name_of = dict(zip(costs["gait_key"], costs["gait"], strict=True))
    legs = scenario.robot.mirror_permutation
    image_of = {key: gait_of(Pattern.from_text(key).mirrored(legs)).text for key in name_of}
    return {name: name_of[image_of[key]] for key, name in name_of.items() if image_of[key] in name_of}


@dataclass(frozen=True)
class MirrorImages:
    """What a mirror does to tasks and classes: `signs` [axes] are 1, or -1 for values that change their sign.

    `classes` [C]: the place of each class's image, and its own where the image is no class.
    """

    signs: tuple[float, ...]
    classes: tuple[int, ...]

    @classmethod
    def of(cls, axes: Sequence[str], classes: Sequence[str], image_of: Mapping[str, str]) -> MirrorImages:
        """Over some axes, of classes of which `image_of` names the images."""
        place = {name: number for number, name in enumerate(classes)}
        images = [place.get(image_of.get(name, name), number) for number, name in enumerate(classes)]
        return cls(tuple(signs_of(tuple(axes)).tolist()), tuple(images))

    def partners(self, tasks: Floats, y: Integers) -> Integers:
        """For each task with its class, of tasks [n, axes] and y [n], the number of its image; -1 where it has none."""

        def asked(task: Floats, one: int) -> tuple[bytes, int]:
            return (np.asarray(task, dtype=np.float32) + 0.0).tobytes(), one  # adding 0 turns -0 into 0

        number = {asked(task, one): i for i, (task, one) in enumerate(zip(tasks, y.tolist(), strict=True))}
        images = np.asarray(tasks) * np.array(self.signs)
        of_images = np.array(self.classes)[y].tolist()
        return np.array([number.get(asked(*pair), -1) for pair in zip(images, of_images, strict=True)], dtype=np.int64)
