"""Before a certificate is asked: random picks are planned, and where one has no motion its border is looked for.

Planning a pick costs a hundredth of a search, so places that only the certificate would find are found before. The
tasks are drawn anew each time, and none of them is one of the certificate's.
"""

from __future__ import annotations

from gaitflow.certificate.draw import draw_tasks
from gaitflow.sampling.making import MapInMaking

DRAWS = 4


def rehearse(making: MapInMaking, number: int, seed: int) -> int:
    """Plan `number` random picks, up to DRAWS times, until each has a motion; how many of the last draw had none."""
    space, without = making.scenario.tasks.space, []
    for draw in range(DRAWS):
        tasks = draw_tasks(making.domain, space, number, seed + draw, "sampled")
        found = making.has_motion(tasks)
        without = [task for task, has in zip(tasks, found, strict=True) if not has]
        making.tell(f"{len(without)} of {number} random picks have no motion, draw {draw + 1}")
        if not without:
            break
        making.find_borders(without)
    return len(without)
