"""Progress on standard error: a bar on a terminal, elsewhere plain lines that grow rarer with time."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import timedelta
from typing import Protocol

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

FIRST_PAUSE_S, LONGEST_PAUSE_S = 5.0, 60.0
PAUSE_SHARE = 0.05  # of the time that has passed
BAR_WIDTH = 20


class Tell(Protocol):
    """Says how far it is."""

    def __call__(self, text: str, share: float | None = None, notes: Sequence[str] = ()) -> None:
        """`share` is how much is done, from 0 to 1, None where nobody knows; `notes` are lines that stay."""


@contextmanager
def display(title: str, console: Console | None = None) -> Iterator[Tell]:
    """Show what is told, and the time, for the length of a block."""
    console = console or Console(stderr=True)
    with _bar(title, console) if console.is_terminal else _lines(title, console) as tell:
        yield tell


def pause_after(elapsed: float) -> float:
    """Seconds until the next plain line, `elapsed` seconds after the start: the log of a long job stays short."""
    return min(max(FIRST_PAUSE_S, PAUSE_SHARE * elapsed), LONGEST_PAUSE_S)


@contextmanager
def _bar(title: str, console: Console) -> Iterator[Tell]:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(BAR_WIDTH),
        TextColumn("{task.fields[text]}"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console) as bar:
        task = bar.add_task(escape(title), total=None, text="")

        def tell(text: str, share: float | None = None, notes: Sequence[str] = ()) -> None:
            for note in notes:
                bar.console.print(escape(note), highlight=False)
            if share is not None:
                bar.update(task, total=1.0, completed=share)
            bar.update(task, text=escape(text))

        yield tell


@contextmanager
def _lines(title: str, console: Console) -> Iterator[Tell]:
    start, latest, over = time.monotonic(), list[str](), threading.Event()

    def line() -> None:
        if latest:
            elapsed = timedelta(seconds=round(time.monotonic() - start))
            text = f"{title}: {latest[-1]}, {elapsed} elapsed"
            console.print(text, markup=False, highlight=False, soft_wrap=True)

    def repeat() -> None:
        while not over.wait(pause_after(time.monotonic() - start)):
            line()

    def tell(text: str, share: float | None = None, notes: Sequence[str] = ()) -> None:
        for note in notes:
            console.print(note, markup=False, highlight=False, soft_wrap=True)
        latest[:] = [text]

    thread = threading.Thread(target=repeat, daemon=True, name="progress lines")
    thread.start()
    try:
        yield tell
    finally:
        over.set()
        thread.join()
        line()
