"""Processes of this machine, of one thread each, that end with the one that started them."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from typing import Protocol, TypeVar

from gaitflow.execute.line_process import ONE_THREAD, die_with

Item = TypeVar("Item")
Result = TypeVar("Result")


class Calls(Protocol):
    """How work is given to `processes`."""

    def __call__(self, function: Callable[[Item], Result], items: Sequence[Item], share: int = 1) -> Iterator[Result]:
        """Call a function with each of some items, `share` of them by one process at a time; results in their order."""
        ...


@contextmanager
def processes(workers: int) -> Iterator[Calls]:
    """What calls functions in so many processes, each of which starts when it is first needed.

    What a function raises is raised here. An exception that ends the context kills them, whatever they are at.
    """
    spawn = multiprocessing.get_context("spawn")  # the caller may have threads
    others = set(multiprocessing.active_children())
    with ProcessPoolExecutor(workers, spawn, die_with, (os.getpid(),)) as pool:

        def calls(function: Callable[[Item], Result], items: Sequence[Item], share: int = 1) -> Iterator[Result]:
            shares = [items[first : first + share] for first in range(0, len(items), share)]
            with _starting():
                # Not `pool.map`: interrupted, it cancels what is left, which a pool that lost its processes trips over.
                made: list[Future[list[Result]]] = [pool.submit(_results, function, each) for each in shares]
            return (result for each in made for result in each.result())

        try:
            yield calls
        except BaseException:
            for process in set(multiprocessing.active_children()) - others:
                process.kill()
            raise


def _results(function: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    return [function(item) for item in items]


@contextmanager
def _starting() -> Iterator[None]:
    """What processes inherit that are started now: one thread of algebra; and a Ctrl-C is the parent's to handle."""
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    own = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    try:
        yield
    finally:
        for name, value in own.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
