"""Nodes that other processes solve are those of this one, and the processes end with it."""

from __future__ import annotations

import numpy as np
import psutil
import pytest
from tiny_map import GALLOP, SOLVED_AT, solution_of, solved_at, task_of, tiny_domain, tiny_problem

from gaitflow.atlas.grow import Growth, grow
from gaitflow.core.gaits import Pattern
from gaitflow.execute.node_processes import node_processes

PATTERN, *TASK = SOLVED_AT[GALLOP]


def grown(workers: int) -> Growth:
    seed = solution_of(PATTERN, task_of(*TASK), solved_at(GALLOP))
    with node_processes(tiny_problem().scenario, workers) as each:
        return grow(tiny_problem(), [Pattern.from_text(PATTERN)], [seed], tiny_domain(), each=each)


def solving() -> set[psutil.Process]:
    """Processes of this one that were started as ours are."""
    return {child for child in psutil.Process().children() if "spawn_main" in " ".join(child.cmdline())}


def test_nodes_are_the_same_whoever_solves_them() -> None:
    before = solving()
    here, there = grown(1), grown(2)
    assert solving() <= before, "they have ended"
    assert there.solver.solves == here.solver.solves > 20
    assert list(there.nodes[0]) == list(here.nodes[0])
    for place, node in here.nodes[0].items():
        assert there.nodes[0][place].cost == node.cost
        np.testing.assert_array_equal(there.nodes[0][place].tangents, node.tangents)


def test_what_a_process_raises_is_raised_here() -> None:
    with node_processes(tiny_problem().scenario, 2) as each:
        assert each is not None
        with pytest.raises(AttributeError, match="no_method"):
            each("no_method", [(Pattern.from_text(PATTERN), ())] * 2)
