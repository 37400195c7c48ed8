"""Before a certificate is asked: random picks are planned, and what is suspicious of them is looked at closely.

Planning a pick costs a hundredth of a search, so much that only the certificate would find is found before: picks that
have no motion, that turn out dearer than another gait is predicted to be, or that stand where a cheaper gait is half
believed. The tasks are drawn anew each time, and none of them is one of the certificate's.
"""

from __future__ import annotations

from gaitflow.certificate.draw import draw_tasks
from gaitflow.sampling.making import MapInMaking
from gaitflow.sampling.picks import Picks

DRAWS = 2


def rehearse(making: MapInMaking, picks: Picks, number: int, seed: int) -> int:
    """Plan `number` random picks, DRAWS times or until none is suspicious.

    Returns at how many tasks of the last draw the map lacks a gait: its pick has no motion, or one that the map does
    not pick from is predicted to cost less.
    """
    space, lacking = making.scenario.tasks.space, 0
    for draw in range(DRAWS):
        suspects = picks.suspects(draw_tasks(making.domain, space, number, seed + draw, "sampled"))
        without = sum(one.infeasible for one in suspects)
        lacking = sum(one.infeasible or one.missing for one in suspects)
        making.tell(f"of {number} random picks {len(suspects)} are suspicious, {without} have no motion")
        if not suspects:
            break
        picks.look_closely(suspects)
    return lacking
