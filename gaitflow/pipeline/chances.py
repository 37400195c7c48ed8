"""How likely each gait of a map in the making is the best, by the classifier that would be published with it."""

from __future__ import annotations

import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.trajectory import Array
from gaitflow.learn.installed import check_installed
from gaitflow.runtime.atlas import NEAR_AXES, Atlas
from gaitflow.runtime.classifier import Classifier
from gaitflow.sampling.making import MapInMaking
from gaitflow.sampling.planning import Chances, Planning


def check_trainable(scenario: Scenario) -> None:
    """Raises ConfigError where a sampling would train a classifier for its plans, and cannot here."""
    if _asks_classifier(scenario):
        check_installed(scenario.learning)


def planning_of(making: MapInMaking) -> Planning:
    """How the map in the making would plan; over so few axes that no plan asks for it, no classifier is trained."""
    atlas = making.built()
    return Planning(making, atlas, chances_of(making, atlas) if _asks_classifier(making.scenario) else None)


def chances_of(making: MapInMaking, atlas: Atlas) -> Chances:
    """The probabilities of the gaits, in the order of `making.gaits`, by a classifier trained as for publishing."""
    from gaitflow.learn.train import KnownCosts, train  # what a sampling over few axes does without

    scenario, axes = making.scenario, making.scenario.tasks.space.ranged
    name_of = dict(zip(making.costs["gait_key"], making.costs["gait"], strict=True))
    names = tuple(name_of[key] for key in making.gaits)
    known = KnownCosts(atlas, names, making.domain)
    # One gait is a map, too: whether it may be published is not asked here.
    training = train(making.labels, making.costs, axes, scenario.learning, True, known, making.tell)
    classifier = Classifier(training.onnx, len(axes), len(training.classes), f"{scenario.name}: the classifier")
    columns = [names.index(gait) for gait in training.classes]

    def chances(places: Array) -> Array:
        found = np.zeros((len(places), len(names)))
        found[:, columns] = classifier(places.astype(np.float32))
        return found

    return chances


def _asks_classifier(scenario: Scenario) -> bool:
    return len(scenario.tasks.space.ranged) > NEAR_AXES
