"""The paper's classifier: a multilayer perceptron with three hidden layers (section III.C)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from typing import Any, Self

import torch
from skorch import NeuralNetClassifier
from skorch.callbacks import LRScheduler
from torch import nn

from gaitflow.learn.mirror import MirrorImages


class Perceptron(nn.Module):
    """Fully connected ReLU layers of the sizes `hidden`: standardised tasks [n, inputs] -> logits [n, classes].

    With `images` a fitted perceptron answers with the mean of what its layers say of a task and of its mirror image.
    """

    def __init__(self, inputs: int, hidden: Sequence[int], classes: int, images: MirrorImages | None = None) -> None:
        super().__init__()
        self.images = images
        sizes = [inputs, *hidden]
        layers: list[nn.Module] = []
        for before, after in pairwise(sizes):
            layers += [nn.Linear(before, after), nn.ReLU()]
        self.layers = nn.Sequential(*layers, nn.Linear(sizes[-1], classes))

    def forward(self, task: torch.Tensor) -> torch.Tensor:
        """Scores [n, classes] of standardised tasks [n, inputs]."""
        scores: torch.Tensor = self.layers(task)
        if self.images is None or self.training:  # it is fitted to tasks and their images alike
            return scores
        signs = torch.tensor(self.images.signs, dtype=task.dtype)
        of_images: torch.Tensor = self.layers(task * signs)[:, list(self.images.classes)]
        return (scores + of_images) / 2


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


def perceptron(
    inputs: int,
    classes: int,
    hidden: Sequence[int],
    max_epochs: int,
    seed: int,
    images: MirrorImages | None = None,
) -> SeededClassifier:
    """An unfitted perceptron for standardised float32 tasks [n, inputs] and int64 classes [n], trained by AdamW.

    Where tasks have mirror `images`, it has to be fitted to both; then the mean of the signed inputs is 0.

    The learning rate falls to 0 along a cosine, so that no fit ends in one of the peaks that the loss has at a constant
    rate. No task is held back to stop by: a map has about a hundred, and a small region would lose its only ones. The
    weight decay, chosen by cross-validation, is what keeps the boundaries smooth.
    """
    falling = LRScheduler("CosineAnnealingLR", T_max=max_epochs)
    return SeededClassifier(
        Perceptron,
        module__inputs=inputs,
        module__hidden=tuple(hidden),
        module__classes=classes,
        module__images=images,
        criterion=nn.CrossEntropyLoss,
        optimizer=torch.optim.AdamW,
        optimizer__fused=True,
        batch_size=-1,  # a map is small: every step sees all of it, and no order of tasks matters
        max_epochs=max_epochs,
        train_split=None,
        callbacks=[("falling", falling)],
        verbose=0,
        seed=seed,
    )
