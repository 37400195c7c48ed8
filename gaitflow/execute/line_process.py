"""A child process that answers a line of JSON with a line of JSON, and may throw through C++, hang or die instead.

`LineProcess` is the parent's side, `serve` the child's. The child has one thread and a session of its own, so that a
terminal's Ctrl-C is the parent's to handle. It ends at the end of its input, and at once when its parent dies.
"""

from __future__ import annotations

import ctypes
import faulthandler
import io
import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import IO, Any, TextIO

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
CHUNK = 1 << 16
MAX_SAID = 1 << 20  # bytes of the child's standard error that are read
PR_SET_PDEATHSIG = 1
PARENT_CHECK_S = 1.0


class Lost(Exception):
    """The child gave no answer: the message says how long it was waited for, and is empty when the child ended."""


class LineProcess:
    """A running child, `python -m module --parent <our id> arguments`. One thread may `ask`, any may `terminate`.

    Start it from a thread that stays: the kernel ends the child together with the *thread* that started it.
    """

    def __init__(self, module: str, arguments: Sequence[str]) -> None:
        self._errors: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115, lives as long as this object
        self._process = subprocess.Popen(
            [sys.executable, "-m", module, "--parent", str(os.getpid()), *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env=os.environ | ONE_THREAD,
            start_new_session=True,
        )

    @property
    def pid(self) -> int:
        """Its process id."""
        return self._process.pid

    @property
    def alive(self) -> bool:
        """Whether it has not ended yet."""
        return self._process.poll() is None

    def ask(self, request: Mapping[str, Any], limit_s: float) -> Any:
        """Send a request and wait for its answer, JSON data both. Raises Lost after `limit_s`, or when it ended."""
        process = self._process
        assert process.stdin is not None and process.stdout is not None
        self._errors.seek(0)  # both sides share the place at which is written
        self._errors.truncate()
        try:
            process.stdin.write(json.dumps(request).encode() + b"\n")
            process.stdin.flush()
        except OSError:
            raise Lost("") from None
        deadline, answer = time.monotonic() + limit_s, b""
        while not answer.endswith(b"\n"):
            left = deadline - time.monotonic()
            if left <= 0 or not select.select([process.stdout], [], [], left)[0]:
                raise Lost(f"hung: no answer in {limit_s:.0f} s")
            block = os.read(process.stdout.fileno(), CHUNK)
            if not block:
                raise Lost("")
            answer += block
        return json.loads(answer)

    def terminate(self, grace_s: float) -> None:
        """Ask it to end, and kill it when it has not ended after `grace_s`."""
        self._process.terminate()
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(grace_s)
        self._process.kill()
        self._process.wait()

    def end(self) -> str:
        """Kill it and forget its pipes; what ended it when that was not us.

        One of "stopped answering", "crashed: SIGSEGV" and "exited with code 3".
        """
        process = self._process
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

    def said(self) -> list[str]:
        """The lines that it wrote to its standard error, or printed, since the last request."""
        self._errors.seek(0)
        return self._errors.read(MAX_SAID).decode(errors="replace").splitlines()


def serve(parent: int, answer: Callable[[Any], str]) -> None:
    """Answer requests from standard input until it ends: `answer` gets JSON data and gives a line of JSON.

    Whatever else prints, from Python or C, goes to standard error if there is room.
    """
    die_with(parent)
    faulthandler.enable()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    answers = _protect_stdout()
    for line in sys.stdin:
        answers.write(answer(json.loads(line)).rstrip("\n") + "\n")
        answers.flush()


def die_with(parent: int) -> None:
    """End this process as soon as `parent` ends, even inside a solver that does not return to Python."""
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(PARENT_CHECK_S)
        os._exit(1)

    if os.getppid() != parent:  # it died before we asked to be told
        os._exit(1)
    threading.Thread(target=watch, daemon=True, name="parent watch").start()


def _protect_stdout() -> TextIO:
    """The stream of answers; standard output is standard error from now on."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    sys.stdout = sys.stderr = io.TextIOWrapper(_Chatter(2, "w", closefd=False), errors="replace", write_through=True)
    return answers


class _Chatter(io.FileIO):
    """What a solver says: losing it, on a scratch disk that is full, must not lose the solution."""

    def write(self, data: Any) -> int:
        try:
            return super().write(data)
        except OSError:
            return memoryview(data).nbytes


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
