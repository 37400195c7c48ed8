"""What was solved, as tables, and what follows from it: the labels of a map.

Reading a dataset needs one function:

    from gaitflow.dataset import load_solutions
    for solution in load_solutions("datasets/half-cheetah-flat-effort/1.0.0"):
        solution.pattern, solution.cost, solution.times, solution.base, solution.forces
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gaitflow.dataset.read import Solutions, load_solutions

__all__ = ["Solutions", "load_solutions"]


def __getattr__(name: str) -> Any:
    # pyarrow takes a while to import, and most users of this package only want a Task.
    if name in __all__:
        from gaitflow.dataset import read

        return getattr(read, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
