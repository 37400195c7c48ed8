"""What Bonmin's log tells of a run: bounds, nodes and incumbents, which CasADi does not hand out.

All objectives here are the program's own, scaled ones; `GaitProblem.cost_scale` times them is a cost.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

NOTHING = 1e49  # Cbc prints 1e+50 for an objective that it does not have

_NUMBER = r"([-+.\deE]+)"
_INCUMBENT = re.compile(
    rf"Integer solution of {_NUMBER} found(?: by (.+?))? after \d+ iterations and (\d+) nodes \({_NUMBER} seconds\)"
)
_PROGRESS = re.compile(
    rf"After (\d+) nodes, \d+ on tree, {_NUMBER} best solution, best possible {_NUMBER} \({_NUMBER} seconds\)"
)
_END = re.compile(
    rf"(Search completed|Partial search) - best objective {_NUMBER}(?: \(best possible {_NUMBER}\))?, "
    rf"took \d+ iterations and (\d+) nodes \({_NUMBER} seconds\)"
)
_PROGRAM = re.compile(rf"^NLP0014I\s+\d+\s+(\S+)\s+{_NUMBER}\s", re.MULTILINE)


@dataclass(frozen=True)
class Incumbent:
    """A point with a whole pattern that Bonmin found: when [s of its CPU time], after how many nodes, and how."""

    time_s: float
    objective: float
    nodes: int
    found_by: str  # "tree", or the name of a heuristic of Cbc's


@dataclass(frozen=True)
class BonminLog:
    """What a log tells of a run, also of one that never ended. None is what was not printed.

    bound is Bonmin's "best possible": the least objective of the open nodes, each a *local* solution of its program.
    """

    relaxation: float | None  # the root's objective
    incumbents: tuple[Incumbent, ...]
    best: float | None
    bound: float | None
    nodes: int
    programs: int  # nonlinear programs solved
    failed_programs: int  # of them, that IPOPT did not solve: those nodes are dropped
    time_s: float | None  # CPU time, by Bonmin's clock
    completed: bool  # the tree was searched to its end

    @property
    def gap(self) -> float | None:
        """(best - bound) / best."""
        return (self.best - self.bound) / abs(self.best) if self.best and self.bound is not None else None


def read_log(text: str) -> BonminLog:
    """Read a log of level 3. Text without any known line is a run of which nothing is known."""
    incumbents: list[Incumbent] = []
    for objective, by, nodes, time in _INCUMBENT.findall(text):
        if not incumbents or float(objective) < incumbents[-1].objective:
            incumbents.append(Incumbent(float(time), float(objective), int(nodes), by or "tree"))
    programs = _PROGRAM.findall(text)
    best = incumbents[-1].objective if incumbents else None
    bound, explored, spent, completed = None, 0, None, False
    for found in _PROGRESS.finditer(text):
        explored, bound, spent = int(found[1]), _objective(found[3]), float(found[4])
    for found in _END.finditer(text):
        completed = found[1] == "Search completed"
        best = _objective(found[2])  # with more digits than before
        bound = best if completed else _objective(found[3])
        explored, spent = int(found[4]), float(found[5])
    return BonminLog(
        relaxation=float(programs[0][1]) if programs and programs[0][0] == "OPT" else None,
        incumbents=tuple(incumbents),
        best=best,
        bound=bound,
        nodes=explored,
        programs=len(programs),
        failed_programs=sum(status == "FAILED" for status, _ in programs),
        time_s=spent,
        completed=completed,
    )


def _objective(text: str | None) -> float | None:
    value = None if text is None else float(text)
    return None if value is None or abs(value) >= NOTHING else value
