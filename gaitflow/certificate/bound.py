"""Exact binomial bounds on a share, and how the chance of error is spent over several askings.

A bound that holds with confidence 1 - a each time it is asked does not hold with 1 - a when one asks until it is good.
So the k-th asking is given a share of the whole chance of error, 6 / (pi k)^2, and all of them together use it up: with
the stated confidence no asking of all that there may ever be is wrong (the union bound).
"""

from __future__ import annotations

import math

from scipy.special import betaincinv

CONFIDENCE = 0.95
ALLOWED = (0, 2, 5, 10)  # dearer picks with which the looks at a certificate, each at more tasks, reach the goal
FORGIVEN, HOPEFUL = 3, 0.5  # failures, and failures over those that the goal allows, after which more tasks are tried
OF_INFEASIBLE = 0.2  # of the chance of error; the bound on dearer picks, whose tasks have to be searched, has the rest
MOST_TASKS = 1_000_000


def upper_bound(failures: int, tasks: int, chance: float) -> float:
    """The largest share of which `failures` of `tasks` or fewer are seen with a probability of `chance`.

    Clopper and Pearson's one-sided bound: the true share exceeds it with a probability of `chance` at most.
    """
    if not 0 <= failures <= tasks or not 0 < chance < 1:
        raise ValueError(f"{failures} failures of {tasks} tasks, chance = {chance:g}: there is no such sample")
    return 1.0 if failures == tasks else float(betaincinv(failures + 1, tasks - failures, 1 - chance))


def tasks_needed(failures: int, share: float, chance: float) -> int:
    """The fewest tasks of which `failures` may fail and the bound still be `share` at most.

    Raises ValueError for a share that takes more than MOST_TASKS.
    """
    low, high = failures, failures + 1
    while upper_bound(failures, high, chance) > share:
        low, high = high, 2 * high
        if high > MOST_TASKS:
            raise ValueError(f"share = {share:g}: takes more than {MOST_TASKS} tasks; allow a larger one")
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if upper_bound(failures, middle, chance) <= share else (middle, high)
    return high


def tasks_of_look(look: int, share: float, asking: int) -> int:
    """The tasks of a certificate at a look, numbered from 0, that is asking number `asking`.

    As many as reach a bound of `share` on dearer picks with ALLOWED[look] of them. They do not depend on what was seen
    at earlier looks: the bound of a sample that grows until it is good would be wrong too often.
    """
    return tasks_needed(ALLOWED[look], share, chances_of(asking)[0])


def has_hope(failures: int, tasks: int, look: int, share: float) -> bool:
    """Whether a further look may show a share of failures below `share`, or whether it is better to mend the map."""
    return look + 1 < len(ALLOWED) and failures <= min(ALLOWED[-1], max(FORGIVEN, HOPEFUL * share * tasks))


def chance_of(asking: int) -> float:
    """The chance of error that the asking of this number, from 1, has for both of its bounds."""
    return (1 - CONFIDENCE) * 6 / (math.pi * asking) ** 2


def chances_of(asking: int) -> tuple[float, float]:
    """Those of an asking's bound on dearer and on infeasible picks."""
    chance = chance_of(asking)
    return (1 - OF_INFEASIBLE) * chance, OF_INFEASIBLE * chance
