"""Processes of this machine end with the work that they were started for."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

INTERRUPTED = """
import os, signal, threading, time
from gaitflow.cli.interrupt import while_running
from gaitflow.execute.spawn import processes

if __name__ == "__main__":
    signal.signal(signal.{signal}, signal.SIG_DFL)  # whoever runs the tests may have it ignored
    with while_running(), processes(2) as calls:
        assert list(calls(abs, range(-3, 2), share=2)) == [3, 2, 1, 0, 1]
        work = calls(time.sleep, [60.0] * 20)
        threading.Timer(0.5, os.kill, (os.getpid(), signal.{signal})).start()
        list(work)
"""


@pytest.mark.parametrize("signal", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_an_interrupt_ends_work_that_has_begun(signal: str, tmp_path: Path) -> None:
    script = tmp_path / "interrupted.py"
    script.write_text(INTERRUPTED.replace("{signal}", signal))
    run = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=50, check=False)
    assert (run.returncode, run.stderr) == (130, "gaitflow: stopped; the same command goes on\n")
