"""A sampling that begins again solves no node twice, and gets the same ones."""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tiny_map import GALLOP, SOLVED_AT, solution_of, solved_at, task_of, tiny_domain, tiny_problem

from gaitflow.atlas.grow import Growth, grow
from gaitflow.atlas.plan_solver import PlanSolver
from gaitflow.core.gaits import Pattern
from gaitflow.pipeline import kept_nodes as module
from gaitflow.pipeline.kept_nodes import kept_nodes
from gaitflow.runtime.starts import Start

PATTERN, *TASK = SOLVED_AT[GALLOP]


class Here:
    """Solves in this process, and counts what it is asked for."""

    def __init__(self) -> None:
        self.asked = list[str]()
        self._solver = PlanSolver(tiny_problem(), [Pattern.from_text(PATTERN)])

    def __call__(self, method: str, calls: Sequence[tuple[Pattern, Sequence[Any]]]) -> list[Any]:
        self.asked += [method] * len(calls)
        numbers = [self._solver.patterns.index(pattern) for pattern, _ in calls]
        return [getattr(self._solver, method)(number, *each) for number, (_, each) in zip(numbers, calls, strict=True)]


def grown(path: Path, here: Here) -> Growth:
    seed = solution_of(PATTERN, task_of(*TASK), solved_at(GALLOP))
    with kept_nodes(path, tiny_problem().scenario, here) as each:
        return grow(tiny_problem(), [Pattern.from_text(PATTERN)], [seed], tiny_domain(), each=each)


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("run") / "sampling" / "nodes.sqlite"
    grown(path, Here())
    return path


def copy(table: Path, target: Path) -> Path:
    (target / "nodes.sqlite").write_bytes(table.read_bytes())
    return target / "nodes.sqlite"


def test_a_second_growth_solves_nothing_and_is_the_same_to_the_last_bit(table: Path, tmp_path: Path) -> None:
    first, again = Here(), Here()
    one, other = grown(tmp_path / "new.sqlite", first), grown(table, again)
    assert len(first.asked) > 10 and not again.asked
    assert list(one.nodes[0]) == list(other.nodes[0])
    for place, node in one.nodes[0].items():
        assert (other.nodes[0][place].place, other.nodes[0][place].cost) == (place, node.cost)
        for name in ("slopes", "point", "tangents"):
            np.testing.assert_array_equal(getattr(other.nodes[0][place], name), getattr(node, name))


def test_what_has_no_motion_is_kept_too(table: Path, tmp_path: Path) -> None:
    here, path = Here(), copy(table, tmp_path)
    node = next(iter(grown(path, here).nodes[0].values()))
    far = tuple(5 * value for value in node.place)
    for _ in range(2):
        with kept_nodes(path, tiny_problem().scenario, here) as each:
            assert each is not None
            assert each("node", [(Pattern.from_text(PATTERN), (far, node.moved(node.place)))]) == [None]
    assert here.asked == ["node"]


def test_costs_are_kept_and_refinements_are_not(table: Path, tmp_path: Path) -> None:
    here, path = Here(), copy(table, tmp_path)
    node = next(iter(grown(path, here).nodes[0].values()))
    call = Pattern.from_text(PATTERN), (node.place, node.moved(node.place), 20)
    hopeless = (call[0], (*call[1][:2], 0))
    for _ in range(2):
        with kept_nodes(path, tiny_problem().scenario, here) as each:
            assert each is not None
            assert each("cost_at", [call, hopeless]) == [pytest.approx(node.cost), None]
    assert here.asked == ["cost_at"] * 2, "the limit of iterations tells two calls apart"
    start = Start(PlanSolver(tiny_problem(), [call[0]]).methods[0].space.decode(call[1][1].point), node.cost, 1e-4)
    tries = [(call[0], (node.place, one, 20)) for one in (start, replace(start, barrier=1e-3), start)]
    for _ in range(2):
        with kept_nodes(path, tiny_problem().scenario, here) as each:
            assert each is not None
            assert each("cost_from", tries) == [pytest.approx(node.cost)] * 3
    assert here.asked[2:] == ["cost_from"] * 2, "a barrier does as well"
    for _ in range(2):
        with kept_nodes(path, tiny_problem().scenario, here) as each:
            assert each is not None and each("refined", [call])[0].converged
    assert here.asked[4:] == ["refined"] * 2


def test_other_code_solves_anew(table: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "package_digest", lambda sources: "other")
    here = Here()
    grown(copy(table, tmp_path), here)
    assert here.asked


def test_a_stopped_growth_goes_on_where_it_was(table: Path, tmp_path: Path) -> None:
    stopped = copy(table, tmp_path)
    with sqlite3.connect(stopped) as connection:
        connection.execute("DELETE FROM nodes WHERE rowid > 5")
    here, whole = Here(), Here()
    grown(stopped, here)
    grown(tmp_path / "new.sqlite", whole)
    assert len(here.asked) == len(whole.asked) - 5


def test_a_long_call_that_is_stopped_keeps_what_was_solved(
    table: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here, path = Here(), copy(table, tmp_path)
    node = next(iter(grown(path, here).nodes[0].values()))
    calls = [(Pattern.from_text(PATTERN), (node.place, node.moved(node.place), limit)) for limit in (20, 21, 22)]

    def stopped(method: str, asked: Sequence[tuple[Pattern, Sequence[Any]]]) -> list[Any]:
        if any(call is calls[-1] for call in asked):
            raise KeyboardInterrupt
        return here(method, asked)

    monkeypatch.setattr(module, "PIECE", 2)
    with kept_nodes(path, tiny_problem().scenario, stopped) as each, pytest.raises(KeyboardInterrupt):
        assert each is not None
        each("cost_at", calls)
    with kept_nodes(path, tiny_problem().scenario, here) as each:
        assert each is not None and each("cost_at", calls) == [pytest.approx(node.cost)] * 3
    assert here.asked == ["cost_at"] * 3


@pytest.mark.parametrize("content", [b"not a database" * 100, b""])
def test_a_file_that_is_none_of_ours_is_named(table: Path, tmp_path: Path, content: bytes) -> None:
    path = copy(table, tmp_path)
    if content:
        path.write_bytes(content)
    else:
        with sqlite3.connect(path) as connection:
            connection.execute("UPDATE nodes SET node = ?", (b"\xff" * 40,))
    with pytest.raises(ValueError, match=r"nodes\.sqlite: .*remove it, and its nodes are solved again"):
        grown(path, Here())


def test_one_process_alone_keeps_nothing(tmp_path: Path) -> None:
    with kept_nodes(tmp_path / "nodes.sqlite", tiny_problem().scenario, None) as each:
        assert each is None
    assert not list(tmp_path.iterdir())
