"""The perceptron: the paper's size, deterministic, and out of the way of other users of torch."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from sklearn.base import clone

from gaitflow.config.scenario import Learning
from gaitflow.learn.mlp import perceptron

RANDOM = np.random.default_rng(0)
TASKS = RANDOM.normal(size=(60, 2)).astype(np.float32)
CLASSES = (TASKS[:, 0] > 0).astype(np.int64) + (TASKS[:, 1] > 0.5)


def fitted_scores(seed: int) -> np.ndarray:
    return perceptron(2, 3, (20, 10, 5), max_epochs=15, seed=seed).fit(TASKS, CLASSES).forward(TASKS).numpy()


@pytest.mark.parametrize("inputs", [1, 2, 3])
@pytest.mark.parametrize("hidden", Learning().hidden_layers)
def test_three_hidden_layers_of_230_neurons_in_all(hidden: tuple[int, ...], inputs: int) -> None:
    network = perceptron(inputs, 4, hidden, max_epochs=1, seed=0).initialize().module_
    linear = [layer for layer in network.layers if isinstance(layer, torch.nn.Linear)]
    assert [layer.in_features for layer in linear] == [inputs, *hidden]
    assert linear[-1].out_features == 4
    assert len(linear) == 4
    assert sum(layer.out_features for layer in linear[:-1]) == 230


def test_a_fit_depends_on_its_seed_alone() -> None:
    first = fitted_scores(seed=3)
    torch.rand(7)
    np.testing.assert_array_equal(fitted_scores(seed=3), first)
    assert not np.array_equal(fitted_scores(seed=4), first)


def test_a_fit_leaves_torch_as_it_was() -> None:
    threads, state = torch.get_num_threads(), torch.get_rng_state()
    perceptron(2, 3, (20, 10, 5), max_epochs=15, seed=3).fit(TASKS, CLASSES)
    assert torch.get_num_threads() == threads
    assert torch.equal(torch.get_rng_state(), state)


def test_cloning_keeps_the_seed() -> None:
    assert clone(perceptron(2, 3, (20, 10, 5), max_epochs=15, seed=9)).seed == 9


def test_it_learns_and_its_last_epochs_change_nothing_any_more() -> None:
    network = perceptron(2, 3, (30, 20, 10), max_epochs=300, seed=0).set_params(lr=1e-2).fit(TASKS, CLASSES)
    losses = network.history[:, "train_loss"]
    assert len(losses) == 300
    assert losses[-1] == pytest.approx(losses[-10], rel=1e-3) and losses[-1] == pytest.approx(min(losses), rel=1e-3)
    assert np.mean(network.predict(TASKS) == CLASSES) > 0.95
