"""The small real map as its publisher makes it."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from tiny_map import TinyMap, parts, preferring, tiny

from gaitflow.publishing import Parts, publish

__all__ = ["parts", "preferring", "tiny"]


@pytest.fixture(scope="session")
def pristine(parts: Parts, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A published version that no test may change."""
    return publish(tmp_path_factory.mktemp("models"), parts, "1.0.0")


@pytest.fixture
def artifact(pristine: Path, tmp_path: Path) -> Path:
    """A published version of one's own: <tmp_path>/quickstart/1.0.0."""
    return Path(shutil.copytree(pristine, tmp_path / "quickstart" / "1.0.0"))


@pytest.fixture(scope="session")
def galloping(parts: Parts, preferring: Callable[[str], TinyMap]) -> Parts:
    """The same map with a classifier that picks the gallop everywhere."""
    return replace(parts, classifier=preferring("gallop").classifier)
