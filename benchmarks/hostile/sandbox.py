"""One question in a forked process under limits of time and memory, and what became of it."""

from __future__ import annotations

import json
import os
import resource
import selectors
import signal
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

Verdict = Literal[
    "same answer", "another answer", "refused", "unsound", "traceback", "memory", "crash", "hang", "outside"
]  # fmt: skip
GOOD: tuple[Verdict, ...] = ("same answer", "another answer", "refused")
CPU_S, WALL_S = 20, 900  # a core may be shared with others
MEMORY = 4 << 30  # bytes of address space beyond what the process has when it forks
RESIDENT = 2 << 30  # bytes of memory likewise
LONGEST_LINE = 1000
MOST_LINES = 21  # of an error that has one a fault


class Unsound(Exception):
    """An answer that is none: a number that is not finite, a probability that is none."""


@dataclass(frozen=True)
class Outcome:
    """A verdict, and what was answered or said."""

    verdict: Verdict
    told: Any

    def beside(self, original: Outcome) -> Outcome:
        """Whether an answer is that of the undamaged file."""
        if self.verdict == "same answer" and self.told != original.told:
            return Outcome("another answer", self.told)
        return self


def ask(
    question: Callable[[], Any],
    refusals: tuple[type[Exception], ...],
    cpu_s: int = CPU_S,
    within: Path | None = None,
) -> Outcome:
    """What a question, whose answer is JSON data, comes to in a process of its own; `refusals` are clear errors.

    The process runs in the folder `within`, where a relative path that somebody made up would lead to.
    """
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        _answer(question, refusals, writer, cpu_s, within)
    os.close(writer)
    told, hung = _read(reader, child)
    _, status = os.waitpid(child, 0)
    if hung or (os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGXCPU):
        return Outcome("hang", f"no answer after {cpu_s} s of CPU or {WALL_S} s")
    if status != 0 or not told:
        ended = f"signal {os.WTERMSIG(status)}" if os.WIFSIGNALED(status) else f"exit {os.WEXITSTATUS(status)}"
        return Outcome("crash", ended)
    return Outcome(*json.loads(told))


def _answer(
    question: Callable[[], Any],
    refusals: tuple[type[Exception], ...],
    writer: int,
    cpu_s: int,
    within: Path | None,
) -> None:
    """Never returns."""
    verdict: Verdict
    try:
        _limit(cpu_s)
        os.chdir(within or ".")
        before = _peak()
        try:
            verdict, told = "same answer", question()
        except Unsound as error:
            verdict, told = "unsound", str(error)
        except refusals as error:
            verdict, told = "refused", str(error)
            lines = told.splitlines()
            if not 0 < len(lines) <= MOST_LINES or not all(len(line) <= LONGEST_LINE for line in lines) or _odd(told):
                verdict, told = "unsound", f"no clear line: {told[:300]!r}"
        except MemoryError:
            verdict, told = "memory", "MemoryError"
        except BaseException as error:
            verdict, told = "traceback", f"{type(error).__name__}: {str(error)[:200]}"
        if (grown := _peak() - before) > RESIDENT:
            verdict, told = "memory", f"{grown} bytes"
        with open(writer, "w", encoding="utf-8") as pipe:
            json.dump([verdict, told], pipe)
    except BaseException:
        os._exit(70)
    os._exit(0)


def _odd(told: str) -> bool:
    """Whether a text would do more in a terminal than be read."""
    return not all(letter.isprintable() or letter == "\n" for letter in told)


def _peak() -> int:
    """The most memory [bytes] that this process has had."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _limit(cpu_s: int) -> None:
    used = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, used + MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (cpu_s, cpu_s + 5))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    nowhere = os.open(os.devnull, os.O_RDWR)
    for descriptor in (0, 1, 2):
        os.dup2(nowhere, descriptor)


def _read(reader: int, child: int) -> tuple[bytes, bool]:
    """All that the child says, and whether it had to be killed."""
    said, until, hung = b"", time.monotonic() + WALL_S, False
    with selectors.DefaultSelector() as ready, open(reader, "rb", buffering=0) as pipe:
        ready.register(pipe, selectors.EVENT_READ)
        while True:
            if not ready.select(max(0.0, until - time.monotonic())):
                hung = True
                with suppress(ProcessLookupError):
                    os.kill(child, signal.SIGKILL)
                return said, hung
            block = pipe.read(1 << 16)
            if not block:
                return said, hung
            said += block
