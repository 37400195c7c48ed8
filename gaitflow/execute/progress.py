"""Progress of a run: units, solves inside them, the time left."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta

from rich.console import Console

from gaitflow.execute.count import OnEvent, RunState
from gaitflow.execute.display import Tell, display


@contextmanager
def progress(title: str, console: Console | None = None) -> Iterator[OnEvent]:
    """The `on_event` of `run_units` for the length of a block."""
    with display(title, console) as tell:
        yield lambda state: tell(describe(state), share(state), state.notes)


def describe(state: RunState) -> str:
    """Counts and the time left, such as "12 of 20 units, 310 of about 520 solves, 0:00:40 to go"."""
    texts = [f"{state.total - state.left} of {state.total} units"]
    if state.failed:
        texts[0] += f" ({state.failed} failed)"
    if state.left and state.solves_left is not None:
        texts.append(f"{state.solves} of about {state.solves + round(state.solves_left)} solves")
    elif state.in_work and state.left:
        texts.append(f"{state.in_work} begun")
    if state.left and state.seconds_left is not None:
        texts.append(f"{timedelta(seconds=round(state.seconds_left))} to go")
    return ", ".join(texts)


def share(state: RunState) -> float:
    """How much of what was missing is done, from 0 to 1."""
    if state.solves_left is not None and state.left:
        return state.solves / max(1.0, state.solves + state.solves_left)
    return 1 - state.left / max(1, state.total - state.found)


def countdown(tell: Tell, name: str) -> Callable[[int, int], None]:
    """Tells of things of one kind, given how many are done and about how many there will be."""
    start = time.monotonic()

    def on_done(done: int, about: int) -> None:
        left = timedelta(seconds=round((time.monotonic() - start) / done * (about - done)))
        tell(f"{done} of about {about} {name}, {left} to go", done / about)

    return on_done
