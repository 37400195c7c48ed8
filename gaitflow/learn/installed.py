"""Whether what a scenario's methods need is installed: asked before anything is solved, without loading any of it."""

from __future__ import annotations

from importlib.util import find_spec

from gaitflow.config.file import ConfigError
from gaitflow.config.scenario import Learning


def what_lacks(learning: Learning) -> str | None:
    """What is not installed for the learning, and the two ways out, in one line; None where it can be done here."""
    if "mlp" not in learning.methods or (find_spec("torch") and find_spec("skorch")):
        return None
    others = ", ".join(name for name in learning.methods if name != "mlp") or "svm, forest, knn"
    return (
        "learning.methods: mlp, the paper's perceptron, needs PyTorch, which is not installed: install the build "
        'for CPUs as PyTorch\'s install page says, then pip install "gaitflow[mlp]"; or do without it: '
        f"learning: {{methods: [{others}]}}"
    )


def check_installed(learning: Learning) -> None:
    """Raises ConfigError when the perceptron is to be trained and PyTorch or skorch is not there."""
    if lacking := what_lacks(learning):
        raise ConfigError(lacking)
