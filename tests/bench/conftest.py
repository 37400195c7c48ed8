"""The small real map of the artifact's tests, and a scenario so small that a search takes seconds."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

from gaitflow.scenario import Scenario, load_scenario

_SPEC = importlib.util.spec_from_file_location("tiny_map", Path(__file__).parents[1] / "artifact" / "tiny_map.py")
assert _SPEC is not None
assert _SPEC.loader is not None
if "tiny_map" not in sys.modules:
    sys.modules["tiny_map"] = importlib.util.module_from_spec(_SPEC)
    _SPEC.loader.exec_module(sys.modules["tiny_map"])

from tiny_map import parts, pristine  # noqa: E402

__all__ = ["parts", "pristine"]


@pytest.fixture(scope="session")
def scenario(checkout: Path) -> Scenario:
    """Quickstart with 3 knots a phase and one random restart."""
    data = load_scenario(checkout / "configs/scenarios/quickstart.yaml").as_data()
    data["transcription"]["knots_per_phase"] = 3
    data["strategy"]["restarts"] = 1
    return Scenario.from_data(data, "test")


@pytest.fixture
def bench_factories(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lets child processes import this folder's `factories`."""
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
