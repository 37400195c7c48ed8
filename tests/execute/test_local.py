from __future__ import annotations

import getpass
import json
import os
import pwd
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import dask
import pytest
from distributed import Client

from gaitflow.execute.drivers import DriverAlive, the_local_driver
from gaitflow.execute.local import local_client, local_run_client


def _inside() -> tuple[str | None, bool]:
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, set())
    return os.environ.get("OMP_NUM_THREADS"), signal.SIGINT in blocked


def test_two_workers_of_one_thread_on_loopback(client: Client) -> None:
    client.wait_for_workers(2)
    workers = client.scheduler_info(n_workers=-1)["workers"]
    assert [worker["nthreads"] for worker in workers.values()] == [1, 1]
    addresses = [client.scheduler.address, *workers]
    assert all(address.startswith("tls://127.0.0.1:") for address in addresses)
    port = int(client.scheduler.address.rsplit(":", 1)[1])
    others = {info[4][0] for info in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)}
    for host in others - {"127.0.0.1", "127.0.1.1"}:
        with socket.socket() as probe:
            probe.settimeout(1)
            assert probe.connect_ex((host, port)) != 0, f"reachable at {host}"


def test_workers_have_one_thread_and_never_see_ctrl_c_even_when_replaced(client: Client) -> None:
    before = client.run(os.getpid)
    assert set(client.run(_inside).values()) == {("1", True)}
    os.kill(next(iter(before.values())), signal.SIGKILL)
    deadline = time.monotonic() + 30
    while len(set(pids := client.run(os.getpid, on_error="ignore").values()) - set(before.values())) < 1:
        assert time.monotonic() < deadline
        time.sleep(0.1)
    client.wait_for_workers(2)
    assert len(set(pids)) >= 1
    assert set(client.run(_inside).values()) == {("1", True)}


def test_a_worker_is_replaced_however_long_its_start_takes() -> None:
    """Dask by itself gives up a worker that has not come back after 15 s, here at once."""
    with dask.config.set({"distributed.deploy.lost-worker-timeout": "10ms"}), local_client(workers=1) as client:
        for _ in range(2):
            (before,) = client.run(os.getpid).values()
            os.kill(before, signal.SIGKILL)
            deadline = time.monotonic() + 60
            while not (set(client.run(os.getpid, on_error="ignore").values()) - {before}):
                assert time.monotonic() < deadline, "nobody starts it again"
                time.sleep(0.1)


STRANGER = """
import gc, os, sys
from distributed import Client, Security
own = dict(tls_ca_file=sys.argv[2], tls_client_cert=sys.argv[2], tls_client_key=sys.argv[3])
key = Security(require_encryption=True, **own)
os.setgroups([]), os.setgid(int(sys.argv[5])), os.setuid(int(sys.argv[4]))  # now: the interpreter may be root's alone
for address, credentials in ((sys.argv[1], None), (sys.argv[1].replace("tls", "tcp"), None), (sys.argv[1], key)):
    gc.collect()  # a client that failed must not be collected while the next one starts: both want one lock
    try:
        with Client(address, security=credentials, timeout="3s") as client:
            print("ran code as", client.submit(os.getuid).result(timeout=5))
    except (OSError, TypeError, ValueError, RuntimeError) as error:
        print("refused", type(error).__name__)
"""


@pytest.mark.skipif(os.getuid() != 0, reason="only root may start a process of another user")
@pytest.mark.timeout(300)
def test_another_user_of_the_machine_runs_nothing(client: Client) -> None:
    credentials = client.security.get_tls_config_for_role("client")
    nobody = pwd.getpwnam("nobody")
    arguments = [
        client.scheduler.address,
        credentials["cert"],
        credentials["key"],
        str(nobody.pw_uid),
        str(nobody.pw_gid),
    ]
    command = [sys.executable, "-c", STRANGER, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)
    said = done.stdout.split("\n")[:-1]
    assert [line.split()[0] for line in said] == ["refused"] * 3, done.stdout + done.stderr
    assert said[2] == "refused PermissionError"
    assert client.submit(os.getuid).result(timeout=20) == 0, "the run is still well"


def test_a_run_has_one_driver(tmp_path: Path) -> None:
    code = "import sys; from pathlib import Path; from gaitflow.execute.drivers import the_local_driver as d\n"
    code += "with d(Path(sys.argv[1])): print('drives', flush=True); sys.stdin.read()"
    other = subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        assert other.stdout is not None and other.stdout.readline() == "drives\n"
        told = rf"the process {other.pid} of {getpass.getuser()} on \S+ solves it; end that one first"
        with pytest.raises(DriverAlive, match=told), local_run_client(tmp_path, 1):
            pass
    finally:
        other.kill()
        other.wait()
    with the_local_driver(tmp_path):  # what a killed one left is no hindrance
        assert json.loads((tmp_path / "driver.json").read_text())["pid"] == os.getpid()
    assert not (tmp_path / "driver.json").exists()


def test_our_own_process_still_sees_ctrl_c(client: Client) -> None:
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, set())
