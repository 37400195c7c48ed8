"""Work in a process of its own, one thread, that may throw through C++, hang or die without ending the bench.

The child is `python -m benchmarks.child module:factory`. Lines of JSON come in: first the factory's arguments,
then those of one call of what it made a line; a line of JSON goes out for each.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import resource
import select
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from types import TracebackType
from typing import IO, Any, Self, TextIO

from gaitflow.execute.reap import reap
from gaitflow.execute.solver import ONE_THREAD
from gaitflow.execute.solver_process import die_with

START_UP_S = 120.0
CHUNK = 1 << 16


class Lost(Exception):
    """The child ended or hung in a call: the message says how; CPU and wall time [s] that went with it."""

    def __init__(self, reason: str, cpu_s: float, wall_s: float) -> None:
        super().__init__(reason)
        self.cpu_s = cpu_s
        self.wall_s = wall_s


class ChildError(RuntimeError):
    """The code in the child raised a Python exception, which no solver does: the message is its traceback."""


class Child:
    """A process that calls `factory(**setup)` once and what that returns at every `call`.

    `factory` is "module:name". A lost process is replaced at the next call, set up anew. Use as a context manager.
    """

    def __init__(self, factory: str, setup: Mapping[str, Any]) -> None:
        self._factory = factory
        self._setup = setup
        self._errors: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115, lives as long as this object
        self._process: subprocess.Popen[bytes] | None = None
        self._spent = 0.0  # CPU time [s] that the process accounted for in its answers

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._end()
        self._errors.close()

    def call(self, limit_s: float, **request: Any) -> Any:
        """The answer to one call, JSON data. Raises Lost after `limit_s` of wall time or when the child died.

        Raises ChildError when the called code raised.
        """
        if self._process is None:
            self._start()
            self._ask(self._setup, START_UP_S)
        return self._ask(request, limit_s)

    def _start(self) -> None:
        self._errors.seek(0)
        self._errors.truncate()
        self._spent = 0.0
        self._process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.child", "--parent", str(os.getpid()), self._factory],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env=os.environ | ONE_THREAD,
            start_new_session=True,  # a terminal's Ctrl-C is the bench's, which then ends the child
        )

    def _ask(self, request: Mapping[str, Any], limit_s: float) -> Any:
        line = self._exchange(json.dumps(request).encode() + b"\n", limit_s)
        answer = json.loads(line)
        self._spent = answer["cpu_s"]
        if "error" in answer:
            self._end()
            raise ChildError(answer["error"])
        return answer["result"]

    def _exchange(self, request: bytes, limit_s: float) -> bytes:
        """Send a line and wait for a line."""
        process = self._process
        assert process is not None and process.stdin is not None and process.stdout is not None
        start, answer = time.monotonic(), b""
        with suppress(BrokenPipeError):  # a dead process gives no answer either
            process.stdin.write(request)
            process.stdin.flush()
        while not answer.endswith(b"\n"):
            left = start + limit_s - time.monotonic()
            if left <= 0 or not select.select([process.stdout], [], [], left)[0]:
                raise self._lost(f"hung: no answer in {limit_s:.0f} s", start)
            block = os.read(process.stdout.fileno(), CHUNK)
            if not block:
                raise self._lost("", start)
            answer += block
        return answer

    def _lost(self, reason: str, start: float) -> Lost:
        wall, before = time.monotonic() - start, _ended_cpu()
        ending = self._end()
        return Lost(reason or ending, max(0.0, _ended_cpu() - before - self._spent), wall)

    def _end(self) -> str:
        """Kill and reap the process; what ended it when it was not us."""
        process, self._process = self._process, None
        if process is None:
            return "ended"
        ending = reap(process)
        return f"{ending}: {self._last_error()}" if ending.startswith("exited") else ending

    def _last_error(self) -> str:
        self._errors.seek(0)
        lines = self._errors.read(1 << 20).decode(errors="replace").strip().splitlines()
        return lines[-1][:200] if lines else "no message"


def main(arguments: Sequence[str] | None = None) -> None:
    """Serve calls from standard input until it ends, or until the parent does."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parent", type=int, required=True, help="process to live and die with")
    parser.add_argument("factory", help="module:name")
    options = parser.parse_args(arguments)
    die_with(options.parent)
    # Whatever else prints, from Python or C, goes to standard error.
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    serve(sys.stdin, answers, options.factory)


def serve(requests: Iterable[str], answers: TextIO, factory: str) -> None:
    """Answer each request with {"result" or "error", "cpu_s": CPU time of this process so far}."""
    call = None
    for line in requests:
        answer: dict[str, Any] = {"result": None}
        try:
            if call is None:
                module, _, name = factory.partition(":")
                call = getattr(importlib.import_module(module), name)(**json.loads(line))
            else:
                answer["result"] = call(**json.loads(line))
            text = json.dumps(answer | {"cpu_s": time.process_time()})
        except Exception:
            text = json.dumps({"error": traceback.format_exc(), "cpu_s": time.process_time()})
        answers.write(text + "\n")
        answers.flush()


def _ended_cpu() -> float:
    """CPU time [s] of all children that were reaped."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    main()
