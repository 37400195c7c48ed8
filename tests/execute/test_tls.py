from __future__ import annotations

import asyncio
import gc
import os
import socket
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest
from distributed import Client, LocalCluster, Security

from gaitflow.execute.local import SETTINGS
from gaitflow.execute.tls import security, session_security, tls_files


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    """A scheduler and a worker that use the credentials of the run in tmp_path."""
    import dask

    with (
        session_security(tmp_path) as own,
        dask.config.set(SETTINGS),
        LocalCluster(
            n_workers=1,
            threads_per_worker=1,
            processes=False,
            host="127.0.0.1",
            protocol="tls://",
            security=own,
            dashboard_address=None,
        ) as cluster,
    ):
        yield cluster.scheduler_address


def connect(address: str, credentials: Security | None) -> int:
    with Client(address, security=credentials, timeout="5s") as client:
        return client.submit(lambda: 42).result(timeout=20)


def refused(address: str, credentials: Security | None) -> None:
    with pytest.raises((OSError, TypeError, RuntimeError)):
        connect(address, credentials)
    gc.collect()  # a client that failed must not be finalised in the thread of the next one, which then never starts


def test_those_who_can_read_the_key_connect(address: str, tmp_path: Path) -> None:
    assert address.startswith("tls://")
    assert connect(address, security(tmp_path)) == 42


def test_a_client_without_the_key_is_refused(address: str, tmp_path: Path) -> None:
    refused(address, None)
    refused(address.replace("tls://", "tcp://"), None)
    assert connect(address, security(tmp_path)) == 42, "the scheduler is still well"


def test_a_client_with_another_run_s_key_is_refused(address: str, tmp_path: Path) -> None:
    with session_security(tmp_path / "other") as foreign:
        refused(address, foreign)
    assert connect(address, security(tmp_path)) == 42


def test_bare_bytes_get_no_answer(address: str) -> None:
    host, port = address.removeprefix("tls://").split(":")
    with socket.create_connection((host, int(port)), timeout=5) as plain:
        plain.sendall(b"GET / HTTP/1.0\r\n\r\n")
        plain.settimeout(5)
        try:
            answer = plain.recv(1000)
        except (ConnectionError, TimeoutError):
            answer = b""
    assert b"HTTP" not in answer and b"dask" not in answer


def test_only_the_owner_can_read_the_key_and_it_is_gone_afterwards(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        (tmp_path / "tls").mkdir(mode=0o777)  # left by somebody careless
        with session_security(tmp_path):
            certificate, key = tls_files(tmp_path)
            assert stat.S_IMODE(key.parent.stat().st_mode) == 0o700
            assert {stat.S_IMODE(file.stat().st_mode) for file in (certificate, key)} == {0o600}
            first = key.read_bytes()
        assert not key.parent.exists()
        with session_security(tmp_path):
            assert key.read_bytes() != first, "every session has its own"
    finally:
        os.umask(before)


def test_a_link_in_the_place_of_the_folder_is_refused(tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir(mode=0o755)
    (tmp_path / "tls").symlink_to(elsewhere)
    with pytest.raises(PermissionError, match="folder of your own"), session_security(tmp_path):
        pass
    assert not list(elsewhere.iterdir()) and stat.S_IMODE(elsewhere.stat().st_mode) == 0o755


def test_a_connection_without_encryption_is_never_opened(tmp_path: Path) -> None:
    from distributed.comm import connect as open_comm

    with session_security(tmp_path) as own:
        arguments = own.get_connection_args("client")
        with pytest.raises(RuntimeError, match="encryption required"):
            asyncio.run(open_comm("tcp://127.0.0.1:1", timeout=5, **arguments))
