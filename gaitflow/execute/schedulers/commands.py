"""Calling a scheduler's command: what it printed, or one clear line on why not."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator, Sequence

from gaitflow.execute.schedulers.base import SchedulerError

COMMAND_LIMIT_S = 120.0
IDS_AT_ONCE = 500  # in one command


def call(command: Sequence[str], where: str, script: str = "", harmless: str = "") -> str:
    """Standard output of a command of the scheduler `where` that reads `script`. Raises SchedulerError.

    A failure all of whose lines on standard error have a match of the pattern `harmless` is none.
    """
    try:
        done = subprocess.run(
            command,
            input=script,
            capture_output=True,
            text=True,
            timeout=COMMAND_LIMIT_S,
            check=False,
            errors="replace",
        )
    except FileNotFoundError:
        raise SchedulerError(f"{command[0]}: not found; run this where {where} is, such as on a login node") from None
    except subprocess.TimeoutExpired:
        raise SchedulerError(f"{command[0]}: no answer in {COMMAND_LIMIT_S:.0f} s; is {where} up?") from None
    said = done.stderr.strip().splitlines()
    if done.returncode and not (harmless and said and all(re.search(harmless, line) for line in said)):
        why = re.sub(rf"^(\w+: error|{command[0]}): ", "", said[-1]) if said else f"exit code {done.returncode}"
        raise SchedulerError(f"{command[0]}: {why}")
    return done.stdout


def batches(ids: Sequence[str]) -> Iterator[Sequence[str]]:
    """Ids by as many as one command takes."""
    for start in range(0, len(ids), IDS_AT_ONCE):
        yield ids[start : start + IDS_AT_ONCE]
