"""What `gaitflow doctor` runs inside a job, on a node: `python -m gaitflow.execute.doctor_node FOLDER`.

It writes what it finds into the shared folder, then waits for a question and answers with the time, for the clocks.
"""

from __future__ import annotations

import argparse
import importlib
import json
import platform
import socket
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import gaitflow
from gaitflow.files import publish_once
from gaitflow.tables.solver_code import solver_version

REPORT, QUESTION, ANSWER, TAKEN = "report.json", "question", "answer.json", "taken"
NEEDED = ("casadi", "gaitflow.execute.drain", "gaitflow.search")  # by the solver and by the worker
WAIT_S = 120.0
POLL_S = 0.2


def main() -> None:
    """Report, then answer one question."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--scratch", default="")
    options = parser.parse_args()
    publish_once(options.folder / REPORT, json.dumps(report(options.folder, options.scratch)).encode())
    deadline = time.monotonic() + WAIT_S
    while not (options.folder / QUESTION).exists() and time.monotonic() < deadline:
        time.sleep(POLL_S)
    publish_once(options.folder / ANSWER, json.dumps({"time": time.time()}).encode())


def report(folder: Path, scratch: str) -> dict[str, Any]:
    """What this node is and can do, as plain data."""
    return {
        "host": socket.gethostname(),
        "interfaces": [name for _, name in socket.if_nameindex()],
        "scratch": _scratch_fault(scratch),
        "took_taken_name": publish_once(folder / TAKEN, b"node"),
        **environment(),
    }


def environment() -> dict[str, Any]:
    """What has to be the same here and on a node, and whether a worker and its solver can be loaded."""
    try:
        for module in NEEDED:
            importlib.import_module(module)
        fault = ""
    except ImportError as error:
        fault = str(error)
    return {
        "gaitflow": gaitflow.__version__,
        "python": platform.python_version(),
        "executable": sys.executable,
        "solver": solver_version(),
        "import_fault": fault,
    }


def _scratch_fault(scratch: str) -> str:
    """Why nothing can be written to the scratch folder (by default that for temporary files), "" when it can."""
    try:
        with tempfile.TemporaryFile(dir=scratch or None) as file:
            file.write(bytes(1 << 20))
    except OSError as error:
        return str(error)
    return ""


if __name__ == "__main__":
    main()
