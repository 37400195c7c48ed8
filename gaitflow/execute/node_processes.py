"""Processes that solve nodes of an atlas side by side, each with the problem of its own."""

from __future__ import annotations

import functools
import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from gaitflow.atlas.node import Each
from gaitflow.atlas.plan_solver import PlanSolver
from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern
from gaitflow.execute.spawn import processes
from gaitflow.problem import transcribe

PARTS = 4  # of its share that a process gets at once: solves take unequal times


@contextmanager
def node_processes(scenario: Scenario, workers: int) -> Iterator[Each | None]:
    """What calls a `PlanSolver` in so many processes, which start when they are first needed; None for one.

    Results are those of a call in this process, to the last bit.
    """
    if workers == 1:
        yield None
        return
    text = json.dumps(scenario.as_data())
    with processes(workers) as in_processes:

        def each(method: str, calls: Sequence[tuple[Pattern, Sequence[Any]]]) -> list[Any]:
            share = max(len(calls) // (PARTS * workers), 1)
            return list(in_processes(functools.partial(_call, text, method), calls, share))

        yield each


def _call(scenario: str, method: str, call: tuple[Pattern, Sequence[Any]]) -> Any:
    solver, (pattern, arguments) = _solver(scenario), call
    if pattern not in solver.patterns:
        solver.extend([pattern])
    return getattr(solver, method)(solver.patterns.index(pattern), *arguments)


@functools.lru_cache(maxsize=1)
def _solver(scenario: str) -> PlanSolver:
    return PlanSolver(transcribe(Scenario.from_data(json.loads(scenario), "atlas")), [])
