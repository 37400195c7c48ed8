"""Work in a process of its own, one thread, that may throw through C++, hang or die without ending the bench.

The child is `python -m benchmarks.child module:factory`, driven as `gaitflow.execute.line_process` says: the first
request has the factory's arguments, every other one those of a call of what it made.
"""

from __future__ import annotations

import argparse
import importlib
import json
import resource
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from types import TracebackType
from typing import Any, Self

from gaitflow.execute import line_process
from gaitflow.execute.line_process import LineProcess

START_UP_S = 120.0


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
        self._process: LineProcess | None = None
        self._spent = 0.0  # CPU time [s] that the process accounted for in its answers

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._end()

    def call(self, limit_s: float, **request: Any) -> Any:
        """The answer to one call, JSON data. Raises Lost after `limit_s` of wall time or when the child died.

        Raises ChildError when the called code raised.
        """
        if self._process is None:
            self._process, self._spent = LineProcess("benchmarks.child", [self._factory]), 0.0
            self._ask(self._process, self._setup, START_UP_S)
        return self._ask(self._process, request, limit_s)

    def _ask(self, process: LineProcess, request: Mapping[str, Any], limit_s: float) -> Any:
        start = time.monotonic()
        try:
            answer = process.ask(request, limit_s)
        except line_process.Lost as lost:
            wall, before = time.monotonic() - start, _ended_cpu()
            ending = self._end()
            raise Lost(str(lost) or ending, max(0.0, _ended_cpu() - before - self._spent), wall) from None
        self._spent = answer["cpu_s"]
        if "error" in answer:
            self._end()
            raise ChildError(answer["error"])
        return answer["result"]

    def _end(self) -> str:
        """Kill the process; what ended it when it was not us."""
        process, self._process = self._process, None
        if process is None:
            return "ended"
        ending = process.end()
        if not ending.startswith("exited"):
            return ending
        said = [line for line in process.said() if line.strip()]
        return f"{ending}: {said[-1][:200] if said else 'no message'}"


def main(arguments: Sequence[str] | None = None) -> None:
    """Serve calls from standard input until it ends, or until the parent does."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parent", type=int, required=True, help="process to live and die with")
    parser.add_argument("factory", help="module:name")
    options = parser.parse_args(arguments)
    line_process.serve(options.parent, answers_of(options.factory))


def answers_of(factory: str) -> Callable[[Mapping[str, Any]], str]:
    """Answers each request by {"result" or "error", "cpu_s": CPU time of this process so far} as a line of JSON."""
    made: list[Callable[..., Any]] = []

    def answer(request: Mapping[str, Any]) -> str:
        told: dict[str, Any] = {"result": None}
        try:
            if made:
                told["result"] = made[0](**request)
            else:
                module, _, name = factory.partition(":")
                made.append(getattr(importlib.import_module(module), name)(**request))
            return json.dumps(told | {"cpu_s": time.process_time()})
        except Exception:
            return json.dumps({"error": traceback.format_exc(), "cpu_s": time.process_time()})

    return answer


def _ended_cpu() -> float:
    """CPU time [s] of all children that were reaped."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    main()
