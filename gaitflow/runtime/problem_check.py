"""problem_check.safetensors: what the map's problem was at a few points, to prove that the one rebuilt is the same.

A map holds its scenario, not its problem: to plan, the installed gaitflow transcribes the scenario anew. The file has
three decision vectors w [3, nw], their tasks on named axes [3, a], and cost [3] and rows [3, ng] of the problem there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from safetensors.numpy import save

from gaitflow.core.layout import Layout
from gaitflow.core.task import AXES, Task
from gaitflow.core.trajectory import Array
from gaitflow.runtime.tensor_file import TensorFile

POINTS = 3
EQUAL = 1e-9  # largest relative difference, of numbers below 1 the absolute one

Nlp = Callable[..., Any]  # (w [nw], task [axes]) -> (cost, rows)


@dataclass(frozen=True, eq=False)
class ProblemCheck:
    """Decision vectors w [3, nw], values of their tasks [3, a] on `axes`, and the problem's cost [3] and rows [3, ng].

    An axis that is not named has its default: so the file stays valid when tasks gain an axis.
    """

    axes: tuple[str, ...]
    w: Array
    tasks: Array
    costs: Array
    rows: Array

    def differs(self, nlp: Nlp) -> str | None:
        """What of a problem differs from what is stored, None where all is equal."""
        for number, (w, values) in enumerate(zip(self.w, self.tasks, strict=True)):
            task = Task.of(dict(zip(self.axes, values.tolist(), strict=True)))
            cost, rows = (np.asarray(each, dtype=float).ravel() for each in nlp(w, task.parameters))
            if rows.shape != self.rows[number].shape:
                return f"it has {rows.size} rows instead of {self.rows[number].size}"
            if fault := _differs(cost, self.costs[number : number + 1]):
                return f"the cost at point {number} differs by {fault:.1e}"
            if fault := _differs(rows, self.rows[number]):
                return f"a row at point {number} differs by {fault:.1e}"
        return None


def record(nlp: Nlp, w: Sequence[Array], tasks: Sequence[Task]) -> ProblemCheck:
    """What a problem is at three decision vectors [nw] and tasks."""
    found = [nlp(each, task.parameters) for each, task in zip(w, tasks, strict=True)]
    return ProblemCheck(
        axes=tuple(AXES),
        w=np.array(w, dtype=float),
        tasks=np.array([task.values for task in tasks]),
        costs=np.array([float(np.asarray(cost, dtype=float).ravel()[0]) for cost, _ in found]),
        rows=np.array([np.asarray(rows, dtype=float).ravel() for _, rows in found]),
    )


def problem_check_bytes(check: ProblemCheck) -> bytes:
    """The file's content."""
    names = np.frombuffer(",".join(check.axes).encode("ascii"), dtype=np.uint8)
    return save({"axes": names, "w": check.w, "tasks": check.tasks, "costs": check.costs, "rows": check.rows})


def parse_problem_check(content: bytes, layout: Layout, rows: int, where: str) -> ProblemCheck:
    """The values in a file's bytes, checked for names, types, shapes and values. Raises ArtifactError."""
    file = TensorFile.parse(content, where)
    file.expect({"axes", "w", "tasks", "costs", "rows"})
    axes = file.names("axes")
    check = ProblemCheck(
        axes=axes,
        w=file.array("w", (POINTS, layout.nw), np.float64),
        tasks=file.array("tasks", (POINTS, len(axes)), np.float64),
        costs=file.array("costs", (POINTS,), np.float64),
        rows=file.array("rows", (POINTS, rows), np.float64),
    )
    for values in check.tasks.tolist():
        try:
            Task.of(dict(zip(axes, values, strict=True)))
        except ValueError as error:
            file.refuse("tasks", f"holds one that is none: {error}")
    return check


def _differs(found: Array, stored: Array) -> float:
    """The largest relative difference, 0 where it is small enough; infinite where a number is none."""
    with np.errstate(invalid="ignore"):
        away = np.abs(found - stored) / np.maximum(np.abs(stored), 1.0)
    largest = float(away.max(initial=0.0))
    return 0.0 if largest <= EQUAL else largest if np.isfinite(largest) else float("inf")
