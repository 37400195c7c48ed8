"""Before a certificate is asked: random picks are planned, and what is suspicious of them is looked at closely.

Planning a pick costs a hundredth of a search, so much that only the certificate would find is found before: picks that
have no motion, that turn out dearer than another gait is predicted to be, or that stand where a cheaper gait is half
believed. The tasks are drawn anew each time, and none of them is one of the certificate's.
"""

from __future__ import annotations

from collections.abc import Sequence

from gaitflow.certificate.draw import draw_tasks
from gaitflow.core.task import Task
from gaitflow.sampling.making import MapInMaking
from gaitflow.sampling.picks import Picks, Suspect

DRAWS = 2


def rehearse(making: MapInMaking, picks: Picks, number: int, seed: int) -> list[Suspect]:
    """Plan `number` random picks, DRAWS times or until none is suspicious; the tasks of the last that lack a gait."""
    space, lacking = making.scenario.tasks.space, list[Suspect]()
    for draw in range(DRAWS):
        suspects = picks.suspects(draw_tasks(making.domain, space, number, seed + draw, "sampled"))
        without = sum(one.infeasible for one in suspects)
        lacking = [one for one in suspects if one.lacks_gait]
        making.tell(f"of {number} random picks {len(suspects)} are suspicious, {without} have no motion")
        if not suspects:
            break
        picks.look_closely(suspects)
    return lacking


def where_missing(suspects: Sequence[Suspect]) -> list[tuple[Task, float]]:
    """For each gait that is missing the task at which it would save most, with that share of the cost, most first.

    A task stands for all gaits that are missing most at it. Equal arguments give equal tasks.
    """
    most: dict[int, tuple[float, Task]] = {}
    for one in suspects:
        for gait, saving in one.missing.items():
            if gait not in most or saving > most[gait][0]:
                most[gait] = saving, one.task
    found: dict[Task, float] = {}
    for saving, task in sorted(most.values(), key=lambda each: -each[0]):
        found.setdefault(task, saving)
    return list(found.items())
