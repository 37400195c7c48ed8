"""Processes of this machine, of one thread each, that end with the one that started them."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager

from gaitflow.execute.line_process import ONE_THREAD, die_with


@contextmanager
def processes(workers: int) -> Iterator[ProcessPoolExecutor]:
    """A pool of so many, each of which starts when it is first needed: hand out work inside `starting`."""
    spawn = multiprocessing.get_context("spawn")  # the caller may have threads
    with ProcessPoolExecutor(workers, spawn, die_with, (os.getpid(),)) as pool:
        yield pool


@contextmanager
def starting() -> Iterator[None]:
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
