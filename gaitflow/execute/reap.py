"""Ending a child process and saying what ended it."""

from __future__ import annotations

import signal
import subprocess
from contextlib import suppress


def reap(process: subprocess.Popen[bytes]) -> str:
    """Kill and reap the process and close its pipes; says what ended it when that was not us.

    One of "stopped answering", "crashed: SIGSEGV" and "exited with code 3".
    """
    with suppress(subprocess.TimeoutExpired):  # a dying process may take a moment to be reported
        process.wait(0.2)
    code = process.poll()
    process.kill()
    process.wait()
    for stream in (process.stdin, process.stdout):
        with suppress(OSError):
            if stream is not None:
                stream.close()
    if code is None:
        return "stopped answering"
    return f"crashed: {_signal_name(-code)}" if code < 0 else f"exited with code {code}"


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
