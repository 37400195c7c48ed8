from __future__ import annotations

import os
import signal
import socket
import time

from distributed import Client


def _inside() -> tuple[str | None, bool]:
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, set())
    return os.environ.get("OMP_NUM_THREADS"), signal.SIGINT in blocked


def test_two_workers_of_one_thread_on_loopback(client: Client) -> None:
    client.wait_for_workers(2)
    workers = client.scheduler_info(n_workers=-1)["workers"]
    assert [worker["nthreads"] for worker in workers.values()] == [1, 1]
    addresses = [client.scheduler.address, *workers]
    assert all(address.startswith("tcp://127.0.0.1:") for address in addresses)
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


def test_our_own_process_still_sees_ctrl_c(client: Client) -> None:
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, set())
