"""What stands in the place of `benchmarks.child.Child`, so that a bench's tests start no process."""

from __future__ import annotations

from typing import Any

import pytest


class PlantedChild:
    """Answers no call; tests say in a class of their own what `call` does."""

    def __init__(self, factory: str, setup: dict[str, Any]) -> None:
        self.setup = setup

    def __enter__(self) -> PlantedChild:
        return self

    def __exit__(self, *error: object) -> None:
        pass

    def call(self, limit_s: float, **request: Any) -> dict[str, Any]:
        pytest.fail("was solved before")
