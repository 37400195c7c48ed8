"""A program that a terminal's Ctrl-C does not reach: we stop it, and wait until all that it started is gone.

Snakemake answers Ctrl-C with a traceback while it starts, and later with words about its jobs. So it has a session of
its own. When we are asked to stop, it is killed, and the command that it runs is interrupted as by a terminal.
"""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from gaitflow.execute.stop_request import SPOKEN_FOR, stop_request

PR_SET_CHILD_SUBREAPER = 36
POLL_S = 0.1
GRACE_S = 30.0  # for the command to end by itself


def run_stoppable(command: Sequence[str], folder: Path, environment: Mapping[str, str]) -> int:
    """Run a program in a folder to its end, and return its exit code.

    Raises KeyboardInterrupt when it was stopped, and everything that it started has ended; see `stop_request`.
    """
    with stop_request() as stop:
        told = {**environment, SPOKEN_FOR: "1"}
        with _interrupts_blocked():
            process = subprocess.Popen(command, cwd=folder, env=told, start_new_session=True)
        while not stop.is_set():
            with suppress(subprocess.TimeoutExpired):
                return process.wait(POLL_S)
        _stop(process)
    raise KeyboardInterrupt


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """What a program inherits: an interruption waits until it unblocks SIGINT, as our commands do when they start.

    Python answers one with a traceback while it starts itself, before a line of ours has run.
    """
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def _stop(process: subprocess.Popen[bytes]) -> None:
    _adopt_orphans()
    process.kill()
    _signal_group(process.pid, signal.SIGINT)
    last_resort = threading.Timer(GRACE_S, _signal_group, (process.pid, signal.SIGKILL))
    last_resort.start()
    process.wait()
    with suppress(ChildProcessError):
        while True:
            os.waitpid(-process.pid, 0)
    last_resort.cancel()


def _adopt_orphans() -> None:
    """Have whatever loses its parent become our child, so that we can wait for it."""
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(PR_SET_CHILD_SUBREAPER, 1)


def _signal_group(group: int, number: int) -> None:
    with suppress(ProcessLookupError):
        os.killpg(group, number)
