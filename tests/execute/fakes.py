"""Solvers with faults, in the place of `gaitflow.search.solve_tasks`; run in the solver process by `--solve`.

What they do is told by the environment, as they run two processes away from the test.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Task
from gaitflow.search.solution import Solution

Seeds = tuple[int, ...] | None


def steady(scenario: Scenario, tasks: Sequence[Task], seeds: Seeds, new_solver: object) -> list[Solution]:
    """A row a task, after FAKE_SLEEP seconds; prints where a solver prints."""
    print("a solver's chatter from Python", flush=True)
    with suppress(OSError):  # which C does not hear of
        os.write(1, b"and from C\n")
    time.sleep(float(os.environ.get("FAKE_SLEEP", "0")))
    return [
        Solution(
            task=task,
            pattern="0110/1100",
            gait="0110/1100",
            strategy=scenario.strategy.name,
            start="nominal",
            seed=0,
            status="solved",
            solver_status="Solve_Succeeded",
            cost=task.speed * task.cycle_duration * scenario.robot.mass,
            violation=0.0,
            iterations=1,
            solves=1,
            wall_s=0.0,
            cpu_s=time.process_time(),
        )
        for task in tasks
    ]


def paced(scenario: Scenario, tasks: Sequence[Task], seeds: Seeds, new_solver: object) -> list[Solution]:
    """`steady`, in the seconds that the file `pace` says; it may change during a solve."""
    pace, begin = Path(os.environ["FAKE_FOLDER"], "pace"), time.monotonic()
    while time.monotonic() - begin < float(pace.read_text()):
        time.sleep(0.05)
    return steady(scenario, tasks, seeds, new_solver)


def hangs_first(scenario: Scenario, tasks: Sequence[Task], seeds: Seeds, new_solver: object) -> list[Solution]:
    """Whoever is first does not come back; `paced` from then on."""
    try:
        Path(os.environ["FAKE_FOLDER"], "hangs").touch(exist_ok=False)
    except FileExistsError:
        return paced(scenario, tasks, seeds, new_solver)
    return hangs(scenario, tasks, seeds, new_solver)


def hoards_first(scenario: Scenario, tasks: Sequence[Task], seeds: Seeds, new_solver: object) -> list[Solution]:
    """Whoever is first takes 1 GB of memory and keeps it; `paced` from then on."""
    try:
        Path(os.environ["FAKE_FOLDER"], "hoards").touch(exist_ok=False)
    except FileExistsError:
        return paced(scenario, tasks, seeds, new_solver)
    Path(os.environ["FAKE_FOLDER"], f"hoards-{os.getpid()}").touch()
    hoard = b"x" * 10**9
    time.sleep(600)
    del hoard
    return []


def hoards_at_slowest(scenario: Scenario, tasks: Sequence[Task], seeds: Seeds, new_solver: object) -> list[Solution]:
    """Of the slowest tasks the shorter one always takes 8 GB of memory, the other one the first time only."""
    if tasks[0].speed == 0.1:
        mark = Path(os.environ["FAKE_FOLDER"], scenario.name)
        first = not mark.exists()
        mark.touch()
        if first or tasks[0].cycle_duration < 0.6:
            hoard = b"x" * (8 << 30)
            raise AssertionError(f"{len(hoard)} bytes were to be had")
    return steady(scenario, tasks, seeds, new_solver)


def throws(scenario: Scenario, tasks: Sequence[Task], seeds: Seeds, new_solver: object) -> list[Solution]:
    raise RuntimeError("Uncaught error in Bonmin")


def dies(scenario: Scenario, tasks: Sequence[Task], seeds: Seeds, new_solver: object) -> list[Solution]:
    print("last words", file=sys.stderr, flush=True)
    os.kill(os.getpid(), signal.SIGSEGV)
    raise AssertionError("unreachable")


def hangs(scenario: Scenario, tasks: Sequence[Task], seeds: Seeds, new_solver: object) -> list[Solution]:
    Path(os.environ["FAKE_FOLDER"], f"hangs-{os.getpid()}").touch()
    time.sleep(600)
    return []


def dies_once(scenario: Scenario, tasks: Sequence[Task], seeds: Seeds, new_solver: object) -> list[Solution]:
    mark = Path(os.environ["FAKE_FOLDER"], scenario.name)
    if not mark.exists():
        mark.touch()
        dies(scenario, tasks, seeds, new_solver)
    return steady(scenario, tasks, seeds, new_solver)


def leaves_tasks_out(scenario: Scenario, tasks: Sequence[Task], seeds: Seeds, new_solver: object) -> list[Solution]:
    return steady(scenario, tasks, seeds, new_solver)[1:]


def dies_at_slowest(scenario: Scenario, tasks: Sequence[Task], seeds: Seeds, new_solver: object) -> list[Solution]:
    if any(task.speed < 0.2 and task.split == "grid" for task in tasks):
        dies(scenario, tasks, seeds, new_solver)
    return steady(scenario, tasks, seeds, new_solver)


def dies_at_first(scenario: Scenario, tasks: Sequence[Task], seeds: Seeds, new_solver: object) -> list[Solution]:
    if tasks[0].speed == 0.1:
        dies(scenario, tasks, seeds, new_solver)
    return paced(scenario, tasks, seeds, new_solver)


def kills_its_worker(scenario: Scenario, tasks: Sequence[Task], seeds: Seeds, new_solver: object) -> list[Solution]:
    """At the first task, as when all processes of a job are killed for its memory: nobody is left to record it."""
    if tasks[0].speed == 0.1 and tasks[0].cycle_duration < 0.6:
        os.kill(os.getppid(), signal.SIGKILL)
        time.sleep(600)
    return steady(scenario, tasks, seeds, new_solver)
