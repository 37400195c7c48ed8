"""The paper's classifier: a multilayer perceptron with three hidden layers (section III.C)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from typing import Any, Self

import torch
from skorch import NeuralNetClassifier
from skorch.callbacks import EarlyStopping
from torch import nn

PATIENCE = 20  # epochs without progress after which training ends
PROGRESS = 1e-4  # fall of the training loss (mean log loss, nats) that counts as progress


class Perceptron(nn.Module):
    """Fully connected ReLU layers of the sizes `hidden`: standardised tasks [n, inputs] -> logits [n, classes]."""

    def __init__(self, inputs: int, hidden: Sequence[int], classes: int) -> None:
        super().__init__()
        sizes = [inputs, *hidden]
        layers: list[nn.Module] = []
        for before, after in pairwise(sizes):
            layers += [nn.Linear(before, after), nn.ReLU()]
        self.layers = nn.Sequential(*layers, nn.Linear(sizes[-1], classes))

    def forward(self, task: torch.Tensor) -> torch.Tensor:
        """Scores [n, classes] of standardised tasks [n, inputs]."""
        scores: torch.Tensor = self.layers(task)
        return scores


class SeededClassifier(NeuralNetClassifier):
    """A skorch classifier whose fit depends on its data and `seed` only, and leaves torch's global state alone."""

    def __init__(self, *args: Any, seed: int = 0, **settings: Any) -> None:
        self.seed = seed
        super().__init__(*args, **settings)

    def fit(self, X: Any, y: Any, **settings: Any) -> Self:
        """Fit to X [n, inputs] float32 and y [n] int64."""
        with _seeded_on_one_thread(self.seed):
            super().fit(X, y, **settings)
        return self


@contextmanager
def _seeded_on_one_thread(seed: int) -> Iterator[None]:
    threads = torch.get_num_threads()
    torch.set_num_threads(1)  # sums in another order on more threads would give other weights
    try:
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)
            yield
    finally:
        torch.set_num_threads(threads)


def perceptron(inputs: int, classes: int, hidden: Sequence[int], max_epochs: int, seed: int) -> SeededClassifier:
    """An unfitted perceptron for standardised float32 tasks [n, inputs] and int64 classes [n], trained by AdamW.

    Training stops early when the training loss no longer falls. No task is held back to stop by: a map has about a
    hundred, and a small region would lose its only ones. The weight decay, chosen by cross-validation, is what keeps
    the boundaries smooth.
    """
    stop = EarlyStopping("train_loss", patience=PATIENCE, threshold=PROGRESS, threshold_mode="abs", sink=_silent)
    return SeededClassifier(
        Perceptron,
        module__inputs=inputs,
        module__hidden=tuple(hidden),
        module__classes=classes,
        criterion=nn.CrossEntropyLoss,
        optimizer=torch.optim.AdamW,
        optimizer__fused=True,
        batch_size=-1,  # a map is small: every step sees all of it, and no order of tasks matters
        max_epochs=max_epochs,
        train_split=None,
        callbacks=[("stop", stop)],
        verbose=0,
        seed=seed,
    )


def _silent(message: str) -> None:
    """Where skorch's remark that training ended goes."""
