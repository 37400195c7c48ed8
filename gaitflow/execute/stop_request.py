"""Being asked to stop: by Ctrl-C, by SIGTERM, or by a terminal that was closed."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SPOKEN_FOR = "GAITFLOW_SPOKEN_FOR"  # in the environment of a command: whoever stops it says so
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextmanager
def stop_request() -> Iterator[threading.Event]:
    """An event that `heard_signals` set, instead of an exception in the middle of whatever is going on."""
    stop = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield stop
        return

    def ask(number: int, frame: FrameType | None) -> None:
        stop.set()

    before = {number: signal.signal(number, ask) for number in heard_signals()}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def heard_signals() -> set[signal.Signals]:
    """The signals that ask to stop; one that the process was told to ignore, as `nohup` does, stays ignored."""
    return {number for number in SIGNALS if signal.getsignal(number) is not signal.SIG_IGN}
