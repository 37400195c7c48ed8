"""How likely each gait of a map in the making is the best, by the classifier that would be published with it."""

from __future__ import annotations

import hashlib

import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.trajectory import Array
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.classifier import Classifier
from gaitflow.sampling.making import MapInMaking
from gaitflow.sampling.planning import Chances, Planning
from gaitflow.tables.solver_code import package_digest


def learning_of(scenario: Scenario) -> str:
    """The digest of what trains the classifier that plans ask: its code and settings."""
    told = f"{package_digest(['learn/*.py'])} {scenario.learning.model_dump_json()}"
    return hashlib.sha256(told.encode()).hexdigest()


def planning_of(making: MapInMaking) -> Planning:
    """How the map in the making would plan, once its classifier is trained."""
    atlas = making.built()
    return Planning(making, atlas, chances_of(making, atlas))


def chances_of(making: MapInMaking, atlas: Atlas) -> Chances:
    """The probabilities of the gaits, in the order of `making.gaits`, by a classifier trained as for publishing."""
    from gaitflow.learn.mirror import images_of_gaits  # what the other commands that know samplings do without
    from gaitflow.learn.train import KnownCosts, train

    scenario, axes = making.scenario, making.scenario.tasks.space.ranged
    name_of = dict(zip(making.costs["gait_key"], making.costs["gait"], strict=True))
    names = tuple(name_of[key] for key in making.gaits)
    known = KnownCosts(atlas, names, making.domain)
    # One gait is a map, too: whether it may be published is not asked here.
    image_of = images_of_gaits(scenario, making.costs)
    training = train(making.labels, making.costs, axes, scenario.learning, True, known, image_of, making.tell)
    classifier = Classifier(training.onnx, len(axes), len(training.classes), f"{scenario.name}: the classifier")
    columns = [names.index(gait) for gait in training.classes]

    def chances(places: Array) -> Array:
        found = np.zeros((len(places), len(names)))
        found[:, columns] = classifier(places.astype(np.float32))
        return found

    return chances
