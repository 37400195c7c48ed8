"""Programs that are stopped with all that they started."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from pathlib import Path

import pytest

from gaitflow.pipeline.stoppable import run_stoppable


def test_a_program_ends_with_its_own_exit_code(tmp_path: Path) -> None:
    assert run_stoppable(["sh", "-c", "exit 3"], tmp_path, os.environ) == 3


def test_a_command_that_is_still_starting_says_nothing(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "sitecustomize.py").write_text("import time; open('started', 'w').close(); time.sleep(1.0)")

    def interrupt() -> None:
        while not (tmp_path / "started").exists():
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt).start()
    # Bash, with which Snakemake runs commands, stands for it: it is killed, and its command is interrupted.
    program = ["bash", "-c", f"{sys.executable} -m gaitflow.cli init workspace; touch next"]
    with pytest.raises(KeyboardInterrupt):
        run_stoppable(program, tmp_path, {**os.environ, "PYTHONPATH": str(tmp_path)})
    assert capfd.readouterr() == ("", "")
    assert not (tmp_path / "workspace").exists() and not (tmp_path / "next").exists()
