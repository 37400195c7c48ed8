"""A map that is its own mirror image: its classifier says the same to the left and to the right."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnxruntime
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitflow.config.scenario import Learning, load_scenario
from gaitflow.learn.cross_validation import stratified_splits
from gaitflow.learn.mirror import MirrorImages, images_of_gaits
from gaitflow.learn.train import Training, train

SCENARIOS = Path(__file__).parents[2] / "configs/scenarios"
AXES = ("speed", "yaw_rate")
IMAGE_OF = {"left": "right", "right": "left", "trot": "trot"}
LABELS = ("left", "right", "trot")


def mirrored_map() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Labels and costs of random tasks and their images: a trot straight on, another gait in each turn."""
    half = np.random.default_rng(0).uniform((0.1, 0.05), (2.0, 0.8), (40, 2))
    places = np.concatenate([half, half * (1, -1)])
    gaits = ["trot" if abs(yaw) < 0.15 + 0.1 * v else ("left" if yaw > 0 else "right") for v, yaw in places]
    labels = pd.DataFrame(places, columns=list(AXES)).assign(
        split="sampled", status="solved", label=gaits, ties=[(gait,) for gait in gaits]
    )
    return labels, labels[[*AXES, "split"]].assign(gait=gaits, excess=0.0)


@pytest.fixture(scope="module")
def mirrored_training() -> Training:
    learning = Learning(
        folds=3,
        methods=("mlp",),
        hidden_layers=((30, 20, 10),),
        learning_rates=(1e-2,),
        weight_decays=(1e-2,),
        max_epochs=60,
    )
    return train(*mirrored_map(), AXES, learning, image_of=IMAGE_OF)


def probabilities(training: Training, tasks: np.ndarray) -> np.ndarray:
    session = onnxruntime.InferenceSession(training.onnx, providers=["CPUExecutionProvider"])
    return np.asarray(session.run(None, {"task": tasks.astype(np.float32)})[0])


@settings(max_examples=30, deadline=None)
@given(speed=st.floats(-1.0, 3.0), yaw_rate=st.floats(-2.0, 2.0))
def test_the_published_classifier_is_its_own_mirror_image(
    mirrored_training: Training, speed: float, yaw_rate: float
) -> None:
    left, right = probabilities(mirrored_training, np.array([[speed, yaw_rate], [speed, -yaw_rate]]))
    np.testing.assert_allclose(right[[1, 0, 2]], left, atol=1e-5)


def test_it_has_learnt_the_map(mirrored_training: Training) -> None:
    assert mirrored_training.classes == LABELS
    labels, _ = mirrored_map()
    picks = probabilities(mirrored_training, labels[list(AXES)].to_numpy()).argmax(axis=1)
    assert np.mean([LABELS[pick] == label for pick, label in zip(picks, labels["label"], strict=True)]) > 0.9


def test_a_task_and_its_image_are_partners_if_their_gaits_are_images() -> None:
    images = MirrorImages.of(AXES, LABELS, IMAGE_OF)
    assert images == MirrorImages((1.0, -1.0), (1, 0, 2))
    tasks = np.array([(1, 0.5), (1, -0.5), (2, 0.5), (2, -0.5), (0.3, 0.0), (3, 0.1), (4, 0.0)], dtype=np.float32)
    y = np.array([0, 1, 0, 2, 2, 2, 0])  # the two of 2 m/s differ, 3 m/s has one only, and a turn is no image of itself
    assert images.partners(tasks, y).tolist() == [1, 0, -1, -1, 4, -1, -1]


def test_a_gait_whose_image_is_no_class_counts_as_its_own() -> None:
    assert MirrorImages.of(AXES, ("left", "trot"), IMAGE_OF).classes == (0, 1)


def test_a_task_and_its_image_are_tested_together_and_every_fit_knows_every_gait() -> None:
    y = np.array([0, 1] * 6 + [2] * 8 + [3, 4] + [0])
    partners = np.array([i ^ 1 for i in range(22)] + [-1])
    splits, remarks = stratified_splits(y, ("left", "right", "trot", "limp", "image"), 5, 0, partners)
    for fit, test in splits:
        assert set(fit).isdisjoint(test) and len(fit) + len(test) == len(y)
        assert set(partners[test]) == set(test)
        assert set(y[fit]) == {0, 1, 2, 3, 4}
    assert sorted(np.concatenate([test for _, test in splits])) == list(range(20)), "one pair, or none, is not tested"
    assert any("never tested: limp, image" in remark for remark in remarks)


def test_gaits_of_a_map_in_every_direction_have_images_by_their_names() -> None:
    costs = pd.DataFrame({"gait": ["trot", "a", "b", "alone"]}).assign(
        gait_key=["01/10/10/01", "0011/1101/1100/0111", "0111/1100/1101/0011", "0011/1100/1100/0111"]
    )
    omni = load_scenario(SCENARIOS / "anymal-omni.yaml")
    assert images_of_gaits(omni, costs) == {"trot": "trot", "a": "b", "b": "a"}
    assert images_of_gaits(load_scenario(SCENARIOS / "anymal-slopes.yaml"), costs) is None
