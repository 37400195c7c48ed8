"""A memory limit that the kernel keeps for a run's processes, as Slurm and containers set one."""

from __future__ import annotations

import json
import secrets
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from gaitflow.config.scenario import Scenario
from gaitflow.dataset import load_solutions
from gaitflow.dataset.collect import collect
from gaitflow.execute.status import run_status
from gaitflow.store.journal import read_journal
from gaitflow.store.parts import UnitStore

LIMIT = 2 << 30  # bytes: driver, two workers and their solvers take half of it
CONTROLLERS = ((Path("/sys/fs/cgroup/memory"), "memory.limit_in_bytes"), (Path("/sys/fs/cgroup"), "memory.max"))


@pytest.fixture
def cgroup() -> Iterator[Path]:
    """A control group with that limit; skipped where this process may make none."""
    reasons = []
    for parent, file in CONTROLLERS:  # version 1 where memory is still under it, version 2
        group = parent / f"gaitflow-{secrets.token_hex(3)}"
        try:
            group.mkdir()
        except OSError as error:
            reasons.append(str(error))
            continue
        try:
            try:
                with (group / file).open("r+") as limit:  # which must be there
                    limit.write(str(LIMIT))
            except OSError as error:
                reasons.append(str(error))
                continue
            yield group
            return
        finally:
            for _ in range(50):  # processes that were killed are in it until they are reaped
                with suppress(OSError):
                    group.rmdir()
                    break
                time.sleep(0.1)
    pytest.skip(f"no memory limits by control groups here, they need root: {'; '.join(reasons)}")


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_a_solver_beyond_the_limit_costs_its_unit_an_attempt_and_nothing_else(
    store: UnitStore, scenario: Scenario, checkout: Path, cgroup: Path, tmp_path: Path
) -> None:
    """One unit always takes more memory than there is, another one the first time only."""
    file = tmp_path / "scenario.json"
    file.write_text(json.dumps(scenario.as_data()))
    enter = ["sh", "-c", f'echo $$ > {cgroup}/cgroup.procs && exec "$0" "$@"']
    drive = [sys.executable, str(checkout / "tests/execute/drive.py"), str(file), str(store.folder)]
    command = [*enter, *drive, "fakes:hoards_at_slowest"]
    run = subprocess.run(command, capture_output=True, text=True, timeout=240)
    assert run.returncode == 0, run.stdout + run.stderr
    status = run_status(scenario, store)
    assert (status.solved, status.failed, status.left) == (5, 1, 0)
    assert Counter(error.reason for error in status.errors) == {"crashed: SIGKILL": 4}
    starts = Counter(entry.unit for entry in read_journal(store.folder / "journal") if entry.event == "start")
    assert sorted(starts.values()) == [1, 1, 1, 1, 2, 3]
    frame = load_solutions(collect(store, scenario)).frame()
    (failed,) = frame[frame["status"] == "failed"].to_dict("records")
    assert failed["solver_status"] == "crashed: SIGKILL x3"
    assert (failed["speed"], failed["cycle_duration"]) == (0.1, 0.4)
