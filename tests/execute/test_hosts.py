"""A run over several hosts: the driver on one, workers on two others, jobs handed out by the stand-in for PBS."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pandas as pd
import pytest
import stand_in_pbs
import yaml
from hosts import INTERFACE, Host, network_of_hosts

from gaitflow.config.scenario import load_scenario
from gaitflow.dataset import load_solutions
from gaitflow.dataset.collect import collect
from gaitflow.execute.local import local_client
from gaitflow.execute.run import run_units
from gaitflow.execute.tls import session_security
from gaitflow.store.journal import read_journal
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import plan_units

PROFILE = {"name": "hosts", "scheduler": "pbs", "walltime": "01:00:00", "jobs": 2, "interface": INTERFACE}
JOIN = """
import sys
from pathlib import Path
from distributed import Client
from gaitflow.execute.tls import security
with Client(sys.argv[1], security=security(Path(sys.argv[2])), timeout="10s") as client:
    print("joined", client.scheduler.address)
"""


@pytest.fixture
def hosts() -> Iterator[list[Host]]:
    with network_of_hosts(3) as hosts:
        yield hosts


@pytest.fixture
def pbs(hosts: list[Host], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The stand-in for PBS, whose jobs run on the second and the third host in turn."""
    folder = tmp_path / "pbs"
    bin = stand_in_pbs.install(folder)
    nodes = " ".join(host.name for host in hosts[1:])
    (bin / "qsub").write_text(
        f"#!/bin/bash\nnodes=({nodes})\nturn=0\n"
        f"until mkdir {folder}/turn-$turn 2>/dev/null; do turn=$((turn + 1)); done\n"
        f"exec ip netns exec ${{nodes[turn % {len(hosts) - 1}]}} "
        f'{sys.executable} {stand_in_pbs.__file__} {folder} qsub "$@"\n'
    )
    monkeypatch.setenv("PATH", f"{bin}:/usr/sbin:/usr/bin:/sbin:/bin")
    return folder


def wait_for(condition: Callable[[], object], seconds: float = 120.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "it took too long"
        time.sleep(0.1)


def join(host: Host, address: str, credentials: Path) -> str:
    """What comes of joining the scheduler from this host with the certificate in a folder."""
    command = host.command(sys.executable, "-c", JOIN, address, str(credentials))
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    return done.stdout if done.returncode == 0 else done.stderr


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_run_over_three_hosts_ends_right_and_a_foreign_certificate_is_refused(
    hosts: list[Host], pbs: Path, checkout: Path, tmp_path: Path
) -> None:
    data = yaml.safe_load((checkout / "configs/scenarios/quickstart.yaml").read_text()) | {"name": "hosts"}
    data["tasks"]["axes"] = {"speed": {"start": 0.5, "stop": 1.1, "count": 4}, "cycle_duration": 0.5}
    data["tasks"]["held_out"], data["strategy"]["tasks_per_unit"] = 0, 1
    (tmp_path / "hosts.yaml").write_text(yaml.safe_dump(data))
    scenario = load_scenario(tmp_path / "hosts.yaml")
    (tmp_path / "profile.yaml").write_text(json.dumps(PROFILE))
    store = UnitStore(tmp_path / "runs" / "hosts")
    (pbs / "hold").touch()
    solve = ["-m", "gaitflow.cli", "--root", str(tmp_path), "solve", "hosts.yaml", "--profile", "profile.yaml"]
    with (
        open(tmp_path / "log", "w+") as log,
        subprocess.Popen(hosts[0].command(sys.executable, *solve), stdout=log, stderr=log, cwd=tmp_path) as run,
    ):
        try:
            wait_for(lambda: run.poll() is not None or list((pbs / "jobs").glob("2.sh")))
            assert run.poll() is None, (tmp_path / "log").read_text()
            address = re.search(r"tls://[\d.]+:\d+", (pbs / "jobs" / "1.sh").read_text())
            assert address is not None and address[0].startswith(f"tls://{hosts[0].address}:")
            with session_security(tmp_path / "foreign"):
                assert "joined" not in (said := join(hosts[1], address[0], tmp_path / "foreign"))
                assert "CERTIFICATE_VERIFY_FAILED" in said or "unknown ca" in said, said
            assert join(hosts[1], address[0], store.folder) == f"joined {address[0]}\n", "the run's own is let in"
            (pbs / "hold").unlink()
            assert run.wait(400) == 0, (tmp_path / "log").read_text()
        finally:
            run.kill()
    logs = "".join(log.read_text() for log in (store.folder / "logs").glob("worker-*"))
    assert set(re.findall(r"Start worker at: +tls://([\d.]+):", logs)) == {host.address for host in hosts[1:]}
    solvers = {entry.solver for entry in read_journal(store.folder / "journal") if entry.event == "stored"}
    assert len(solvers) == 2, "one host solved all"
    alone = UnitStore(tmp_path / "alone")
    assert run_units(plan_units(scenario), alone, lambda: local_client(2)).left == 0
    columns = ["speed", "pattern", "gait", "status", "cost"]
    there, here = (load_solutions(collect(each, scenario)).frame()[columns] for each in (store, alone))
    pd.testing.assert_frame_equal(there, here, check_exact=True)
