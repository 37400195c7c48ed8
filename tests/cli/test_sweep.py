"""`gaitflow sweep` as a user meets it: killed and resumed, then its documents; and what it refuses."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
import yaml
from click.testing import CliRunner, Result

from gaitflow.cli import main
from gaitflow.config.sweep import load_sweep
from gaitflow.dataset.sweep import read_sweep
from gaitflow.pipeline.sweep import PAPERS

SCENARIO = "half-cheetah-flat-effort"
CHECKOUT = Path(__file__).resolve().parents[2]
AXES = {"speed": {"start": 0.3, "stop": 0.7, "count": 2}, "cycle_duration": {"start": 0.6, "stop": 0.6, "count": 1}}


def workspace_with(root: Path, **changes: Any) -> Path:
    """A workspace with a sweep of two robots on two tasks, called as the one that the paper's statements look for."""
    data = {"name": PAPERS, "samples": 2, "ranges": {"inertia": {"factor": [0.5, 2.0]}}, "axes": AXES} | changes
    (root / "configs/sweeps").mkdir(parents=True)
    (root / f"configs/sweeps/{PAPERS}.yaml").write_text(yaml.safe_dump(data), encoding="utf-8")
    return root


def call(root: Path, *arguments: str) -> Result:
    return CliRunner().invoke(main, ["--root", str(root), *arguments])


def parts(run: Path) -> dict[str, int]:
    return {file.name: file.stat().st_mtime_ns for file in run.glob("units/*/*.parquet")}


def killed_after_a_unit(root: Path, run: Path) -> None:
    """Run the sweep in a process group of its own and kill all of it as soon as a unit is stored."""
    command = [sys.executable, "-m", "gaitflow.cli", "--root", str(root), "sweep", SCENARIO, PAPERS, "--workers", "1"]
    paths = {"PYTHONPATH": str(CHECKOUT)}
    with subprocess.Popen(command, env=os.environ | paths, stderr=subprocess.PIPE, start_new_session=True) as process:
        try:
            deadline = time.monotonic() + 120
            while not parts(run):
                assert process.poll() is None and time.monotonic() < deadline
                time.sleep(0.02)
        finally:
            os.killpg(process.pid, signal.SIGKILL)


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_a_sweep_that_was_killed_goes_on_and_is_reported(tmp_path: Path) -> None:
    root = workspace_with(tmp_path)
    run = root / f"runs/{SCENARIO}-{PAPERS}"
    killed_after_a_unit(root, run)
    before = parts(run)
    assert len(before) == 1 and not (run / "sweep.parquet").exists(), "killed too late: the test shows nothing"
    status = json.loads(call(root, "status", SCENARIO, "--sweep", PAPERS, "--json").stdout)
    assert (status["scenario"], status["units"], status["solved"], status["left"]) == (run.name, 2, 1, 1)

    done = call(root, "sweep", SCENARIO, PAPERS, "--workers", "1")
    assert done.exit_code == 0, done.output
    after = parts(run)
    assert len(after) == 2 and before.items() <= after.items(), "nothing is solved twice"
    assert "robots that keep a statement of the paper, by forward Euler:\n  4a-walking" in done.stdout
    assert done.stdout.splitlines()[-1] == str(run / "sweep.parquet")
    table = read_sweep(run / "sweep.parquet")
    assert len(table.frame) == 4 and (table.frame["status"] == "solved").all()
    robots = json.loads((run / "robots.json").read_text())
    assert [robot["robot"]["inertia"][0][0] for robot in robots] == pytest.approx(0.3 * table.parameters["inertia"])
    assert len(set(table.frame.groupby("sample")["cost"].sum().round(3))) == 2, "two robots, two costs"

    assert call(root, "report", "--sweep", PAPERS).exit_code == 0
    written = {file.name for file in (root / "docs/results").iterdir()}
    assert written == {f"sweep-{PAPERS}.{kind}" for kind in ("md", "json", "png")}
    claims = call(root, "report", "--claims").stdout
    titles, _, first, *_ = [line.split(" | ") for line in claims.splitlines()]
    assert first[titles.index("robots, forward Euler")].split(" (")[0] in ("0 of 2", "1 of 2", "2 of 2")
    assert "robots, exact motion" not in titles, "that sweep was not run"


def test_a_report_without_a_run_says_what_to_run(tmp_path: Path) -> None:
    root = workspace_with(tmp_path)
    done = call(root, "report", "--sweep", PAPERS)
    assert done.exit_code == 2
    assert f"no finished run of the sweep {PAPERS} over a scenario of the paper; run `gaitflow sweep" in done.stderr


@pytest.mark.parametrize(
    ("sweep", "said"),
    [
        ({"ranges": {"box.z": [0.1, 0.6]}}, "high end 0.6: robot: legs.F.default_foot"),
        ({"ranges": {"masss": [1.0, 2.0]}}, "no 'masss' there, did you mean mass?"),
        ({"samples": "many"}, "samples = 'many'"),
    ],
)
def test_a_bad_sweep_is_one_line_and_starts_no_work(sweep: dict[str, Any], said: str, tmp_path: Path) -> None:
    root = workspace_with(tmp_path, **sweep)
    done = call(root, "sweep", SCENARIO, PAPERS)
    assert done.exit_code == 2 and said in done.stderr and done.stderr.count("\n") == 1
    assert not (root / "runs").exists()


def test_an_unknown_sweep_suggests_the_nearest(tmp_path: Path) -> None:
    done = call(workspace_with(tmp_path), "sweep", SCENARIO, "half-chetah")
    assert done.exit_code == 2 and "sweep 'half-chetah': neither in" in done.stderr
    assert "did you mean half-cheetah?" in done.stderr
    assert load_sweep(tmp_path / f"configs/sweeps/{PAPERS}.yaml").samples == 2
