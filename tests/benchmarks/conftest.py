"""The small real map of the artifact's tests, and a scenario so small that a search takes seconds."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest
from planted_child import PlantedChild
from tiny_map import parts, pristine, tiny

from benchmarks import child
from benchmarks.child import Lost
from gaitflow.config.scenario import Scenario, load_scenario

__all__ = ["parts", "pristine", "tiny"]


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
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent), prepend=os.pathsep)


@pytest.fixture(scope="session")
def spatial(checkout: Path) -> Scenario:
    """ANYmal with 3 knots in each of 4 phases."""
    data = load_scenario(checkout / "tests/data/scenarios/anymal-flat-vibration.yaml").as_data()
    data["transcription"]["knots_per_phase"] = 3
    data["tasks"]["axes"]["cycle_duration"] = {"start": 0.6, "stop": 0.8, "count": 2}
    return Scenario.from_data(data, "test")


@pytest.fixture
def planted(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Instead of child processes: Bonmin and the big-M form die, the rest finds a gallop; `calls` counts."""

    class Planted(PlantedChild):
        calls = 0

        def call(self, limit_s: float, **request: Any) -> dict[str, Any]:
            Planted.calls += 1
            bonmin = self.setup.get("scenario", {}).get("strategy", {}).get("name") == "bonmin"
            if bonmin or request.get("method") == "bigm_random":
                raise Lost("crashed: SIGABRT", 9.0, 10.0)
            answer = {
                "gait": "gallop", "pattern": "0011/0110", "cost": 100.0, "costs": {"0011/0110": 100.0}, "counts": {},
                "violation": 1e-9, "status": "solved", "solver_status": "Solve_Succeeded", "solves": 3, "wall_s": 4.0,
                "whole_wall_s": 5.0, "cpu_s": 4.0, "whole_cpu_s": 5.0,
            }  # fmt: skip
            return {key: value for key, value in answer.items() if key not in request}

    monkeypatch.setattr(child, "Child", Planted)
    return Planted
