"""Ctrl-C at any moment: one line on standard error and exit code 130, as a shell has it, without a traceback.

The same holds for SIGTERM, which a cluster sends at a job's time limit, and when a terminal is closed.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator, Set
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from gaitflow.execute.stop_request import SPOKEN_FOR, heard_signals

STOPPED = "stopped; the same command goes on"
PATIENCE_S = 3.0
CLEAN_LINE = b"\r\x1b[K\x1b[?25h"  # over a bar, and with the cursor that it hides


@contextmanager
def while_importing() -> Iterator[None]:
    """Leave at once on Ctrl-C: in an import there is nothing to tidy up, and nobody yet who would catch it.

    Where a command starts, it stays so until `while_running`. Python still has to run what it imported, and a signal
    that is blocked here may be heard in a thread that a library has started.
    """
    with _heard({signal.SIGINT}, lambda number, frame: _leave_now(), keep=_starts_command()):
        yield


def _starts_command() -> bool:
    """Whether Python imports us for `python -m gaitflow.cli`, which it calls "-m" so far, or for the script."""
    return bool(sys.argv) and Path(sys.argv[0]).name in ("-m", "gaitflow")


@contextmanager
def while_running() -> Iterator[None]:
    """Let `heard_signals` raise KeyboardInterrupt, so that files half written are removed, and leave when it came up.

    Compiled code may lose that exception, or turn it into another one, and Python itself prints it and goes on in a
    finaliser. So whatever comes up after a signal counts for it, and when nothing does the process is left after
    PATIENCE_S, or at another signal.
    """
    asked = threading.Event()
    last_resort = threading.Timer(PATIENCE_S, _leave_now)
    last_resort.daemon = True

    def interrupt(number: int, frame: FrameType | None) -> None:
        if asked.is_set():
            _leave_now()
        asked.set()
        last_resort.start()
        raise KeyboardInterrupt

    def lost(unraisable: sys.UnraisableHookArgs) -> None:
        if not (asked.is_set() and issubclass(unraisable.exc_type, KeyboardInterrupt)):
            told_before(unraisable)

    told_before, sys.unraisablehook = sys.unraisablehook, lost
    with _heard(heard_signals(), interrupt):
        try:
            yield
        except BaseException as error:
            stopped = isinstance(error, KeyboardInterrupt)
            if not stopped and not asked.is_set():
                raise
            last_resort.cancel()
            _say(str(error) if stopped and str(error) else STOPPED)
            sys.exit(130)
        finally:
            sys.unraisablehook = told_before


@contextmanager
def _heard(signals: Set[signal.Signals], handler: signal._HANDLER, keep: bool = False) -> Iterator[None]:
    """Let a handler have these signals; with `keep` for good, where Python's own had them."""
    # A worker process imports the command line, too, under this name, and its parent stops it. So it leaves SIGINT
    # blocked: threads that libraries start while it is unblocked would hear Ctrl-C as long as the worker lives.
    # Everywhere else multiprocessing makes the same name an alias of the module `__main__`.
    worker = getattr(sys.modules.get("__mp_main__"), "__name__", None) == "__mp_main__"
    if worker or threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {each: signal.signal(each, handler) for each in signals}
    # Whoever starts us may have blocked SIGINT, so that it waits until now: see `run_stoppable`.
    mask = signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for each, earlier in before.items():
            if not (keep and earlier is signal.default_int_handler):
                signal.signal(each, earlier)


def _leave_now() -> None:
    _say(STOPPED)
    os._exit(130)


def _say(message: str) -> None:
    if SPOKEN_FOR not in os.environ:
        start = CLEAN_LINE if os.isatty(2) else b""
        os.write(2, start + f"gaitflow: {message}\n".encode())
