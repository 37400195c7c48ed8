"""What the runtime raises beside ValueError (an argument that is no finite number, and the like)."""

from __future__ import annotations


class ArtifactError(RuntimeError):
    """A map or dataset that cannot be used: names the file, what is wrong with it, and the way out."""


class OutOfDomain(ValueError):
    """A task outside the tasks that the map was made for: names the value and the range."""


class NoTransition(RuntimeError):
    """Two motions between which no feasible transition was found: names both, and the way out."""
