"""Three hosts on one machine: network namespaces, each with an address and a loopback interface of its own.

They share the machine's file system, as the nodes of a cluster do. It takes root and Linux.
"""

from __future__ import annotations

import secrets
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

import pytest

INTERFACE = "fabric0"  # of each host, which a profile names
NETWORK = "10.213.77"


@dataclass(frozen=True)
class Host:
    """A host, by the name of its namespace, and its address on the network of all hosts."""

    name: str
    address: str

    def command(self, *command: str) -> list[str]:
        """What runs this command on the host."""
        return ["ip", "netns", "exec", self.name, *command]


@contextmanager
def network_of_hosts(number: int) -> Iterator[list[Host]]:
    """So many hosts on one switch. The test is skipped where the system does not permit them."""
    mark = f"gf{secrets.token_hex(3)}"
    switch = f"{mark}-switch"
    hosts = [Host(f"{mark}-{i}", f"{NETWORK}.{i + 1}") for i in range(number)]
    with ExitStack() as stack:
        try:
            for name in (switch, *(host.name for host in hosts)):
                _ip("netns", "add", name)
                stack.callback(_ip, "netns", "del", name)
            _connect(switch, hosts)
        except (OSError, subprocess.CalledProcessError) as error:
            why = getattr(error, "stderr", "") or str(error)
            pytest.skip(f"no network namespaces here, they need root and iproute2: {why.strip()}")
        yield hosts


def _connect(switch: str, hosts: Sequence[Host]) -> None:
    _ip("-n", switch, "link", "add", "bridge", "type", "bridge")
    _ip("-n", switch, "link", "set", "bridge", "up")
    for i, host in enumerate(hosts):
        _ip("-n", switch, "link", "add", f"port{i}", "type", "veth", "peer", "name", INTERFACE, "netns", host.name)
        _ip("-n", switch, "link", "set", f"port{i}", "master", "bridge", "up")
        _ip("-n", host.name, "address", "add", f"{host.address}/24", "dev", INTERFACE)
        for interface in ("lo", INTERFACE):
            _ip("-n", host.name, "link", "set", interface, "up")


def _ip(*arguments: str) -> Sequence[str]:
    done = subprocess.run(["ip", *arguments], check=True, capture_output=True, text=True)
    return done.stdout.splitlines()
