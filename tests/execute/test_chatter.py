from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from gaitflow.execute.receipt import Receipt
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full on this system")
def test_a_full_disk_under_a_solvers_chatter_does_not_lose_its_solution(
    units: tuple[Unit, ...], store: UnitStore
) -> None:
    """`steady` prints; standard error is a file on the node's scratch disk."""
    command = [sys.executable, "-m", "gaitflow.execute.solver_process", "--parent", str(os.getpid())]
    request = json.dumps({"unit": units[0].as_data(), "store": str(store.folder), "solver": "7-a"}) + "\n"
    with open("/dev/full", "wb") as full:
        done = subprocess.run(
            [*command, "--solve", "fakes:steady"], input=request.encode(), stdout=subprocess.PIPE, stderr=full
        )
    assert Receipt.from_data(json.loads(done.stdout)) == Receipt(units[0].digest, "solved")
    assert store.has(units[0])
