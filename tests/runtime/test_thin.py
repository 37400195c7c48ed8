from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

HEAVY = {"torch", "dask", "distributed", "casadi", "pandas", "sklearn", "skorch", "pydantic", "scipy", "yaml", "onnx"}


def _modules(report: str) -> set[str]:
    """Top-level modules in what `-X importtime` prints: lines of `self | cumulative | name`."""
    lines = [line for line in report.splitlines() if line.startswith("import time:")]
    return {line.rsplit("|", 1)[1].strip().split(".")[0] for line in lines}


def test_importing_the_runtime_loads_nothing_heavy() -> None:
    command = [sys.executable, "-X", "importtime", "-c", "import gaitflow.runtime"]
    loaded = _modules(subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stderr)
    assert {"gaitflow", "numpy", "onnxruntime", "safetensors"} <= loaded
    assert loaded & HEAVY == set()


def test_answering_loads_nothing_heavy_and_planning_only_solvers(pristine: Path) -> None:
    script = f"""
import sys
from gaitflow.runtime import GaitMap
gait_map = GaitMap.load({str(pristine)!r})
choice = gait_map.select(speed=0.9, cycle_duration=0.6)
choice.warm_start, gait_map.select_many([0.9], [0.6])
print(*sorted({HEAVY!r} & set(sys.modules)))
assert gait_map.plan(speed=0.9, cycle_duration=0.6).feasible
print(*sorted({HEAVY!r} & set(sys.modules)))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.split("\n")[:2] == ["", "casadi pydantic scipy yaml"]


@pytest.mark.parametrize("missing", ["casadi", "pydantic", "qdldl", "scipy.sparse"])
def test_planning_without_a_solver_says_what_to_install(
    artifact: Path, monkeypatch: pytest.MonkeyPatch, missing: str
) -> None:
    from gaitflow.runtime import GaitMap

    monkeypatch.setitem(sys.modules, missing, None)
    gait_map = GaitMap.load(artifact)
    assert gait_map.select(1.7, 0.6).gait == "gallop"
    with pytest.raises(ImportError, match=rf'needs {missing}: pip install "gaitflow\[solve\]"'):
        gait_map.plan(0.9, 0.6)
