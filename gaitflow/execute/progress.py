"""Progress of a run on standard error: a bar on a terminal, a plain line every few seconds elsewhere."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from gaitflow.execute.run import OnEvent, RunState

LINE_EVERY_S = 5.0


@contextmanager
def progress(title: str, console: Console | None = None) -> Iterator[OnEvent]:
    """The `on_event` of `run_units` for the length of a block: counts, elapsed time, time left, and notes."""
    console = console or Console(stderr=True)
    with _bar(title, console) if console.is_terminal else _lines(title, console) as on_event:
        yield on_event


def describe(state: RunState, elapsed_s: float) -> str:
    """Counts and the time left, such as "12 solved, 0 failed, 8 left, 0:00:40 to go"."""
    text = f"{state.solved} solved, {state.failed} failed, {state.left} left"
    done = state.solved + state.failed - state.found
    if state.left and done > 0:
        text += f", {timedelta(seconds=round(elapsed_s / done * state.left))} to go"
    return text


@contextmanager
def _bar(title: str, console: Console) -> Iterator[OnEvent]:
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[counts]}"), TimeElapsedColumn())
    start = time.monotonic()
    with Progress(*columns, console=console) as bar:
        task = bar.add_task(escape(title), total=None, counts="")

        def on_event(state: RunState) -> None:
            for note in state.notes:
                bar.console.print(escape(note), highlight=False)
            counts = describe(state, time.monotonic() - start)
            bar.update(task, total=state.total, completed=state.total - state.left, counts=counts)

        yield on_event


@contextmanager
def _lines(title: str, console: Console) -> Iterator[OnEvent]:
    start, latest, over = time.monotonic(), list[RunState](), threading.Event()

    def line() -> None:
        if latest:
            elapsed = time.monotonic() - start
            text = f"{title}: {describe(latest[-1], elapsed)}, {timedelta(seconds=round(elapsed))} elapsed"
            console.print(text, markup=False, highlight=False, soft_wrap=True)

    def repeat() -> None:
        while not over.wait(LINE_EVERY_S):
            line()

    def on_event(state: RunState) -> None:
        for note in state.notes:
            console.print(note, markup=False, highlight=False, soft_wrap=True)
        latest[:] = [state]

    thread = threading.Thread(target=repeat, daemon=True, name="progress lines")
    thread.start()
    try:
        yield on_event
    finally:
        over.set()
        thread.join()
        line()
