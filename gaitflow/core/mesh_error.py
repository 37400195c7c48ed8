"""How far a cost may be off because motions have only so many knots, from its value on two meshes."""

from __future__ import annotations


def error_left(cost: float, knots: int, refined_cost: float, refined_knots: int) -> float:
    """Relative error that may be left in `refined_cost`, of a mesh with more knots a phase than `cost` is of.

    Takes the error to fall as 1 / knots, which is slower than any rule of ours does: on a twice finer mesh it is as
    large as the two costs differ, on one four times finer a third of that. Raises ValueError for a mesh not finer.
    """
    if refined_knots <= knots:
        raise ValueError(f"{refined_knots} knots a phase are no finer a mesh than {knots}")
    return abs(cost - refined_cost) / abs(refined_cost) / (refined_knots / knots - 1)
