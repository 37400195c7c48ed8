"""From nodes to an atlas: who wins and why, what the modes keep, and what each family predicts."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from gaitflow.atlas import predictors
from gaitflow.atlas.grow import BARRIER, Grown, Node
from gaitflow.atlas.predictors import AS_GOOD, FAMILIES, LIMIT, MODES, NODES, Judgement, build_atlas, table
from gaitflow.publishing import Parts
from gaitflow.runtime.atlas import Atlas

CANDIDATES = [*((NODES, modes) for modes in MODES), *((name, max(MODES)) for name in FAMILIES)]


def test_the_winner_is_the_thinnest_of_those_with_the_fewest_iterations(parts: Parts, judged: tuple) -> None:
    assert [(row.predictor, row.modes) for row in judged] == CANDIDATES
    assert len({row.tasks for row in judged}) == 1 and judged[0].tasks > 20, "all are judged on the same tasks"
    best = min(row.iterations_mean for row in judged)
    good = [row for row in judged if row.iterations_mean <= AS_GOOD * best]
    winner = min(good, key=lambda row: (row.modes, row.iterations_mean))
    assert {len(sheet.modes) for sheet in parts.atlas.sheets} == {winner.modes}
    assert winner.converged > 0.95 * winner.tasks and winner.iterations_mean < 6
    by_name = {row.predictor: row.iterations_mean for row in judged}
    assert by_name["mean"] > 1.5 * best, "the paper's start needs many more"


@pytest.mark.parametrize(
    ("iterations", "winner"),
    [
        ((4.0, 5.0, 5.0, 9.0, 9.0, 9.0), (NODES, MODES[0])),
        ((5.0, 4.0, 3.95, 9.0, 9.0, 9.0), (NODES, MODES[1])),  # as good with fewer modes
        ((5.0, 4.2, 3.95, 9.0, 9.0, 9.0), (NODES, MODES[2])),
        ((5.0, 5.0, 5.0, 9.0, 9.0, 4.0), ("kernel", MODES[2])),
        ((5.0, 5.0, 4.02, 9.0, 4.01, 4.0), ("kernel", MODES[2])),  # with as many modes the fewest iterations
    ],
)
def test_a_predictor_wins_by_iterations_then_by_modes(
    grown: Grown, monkeypatch: pytest.MonkeyPatch, iterations: tuple, winner: tuple[str, int]
) -> None:
    told, tried = dict(zip(CANDIDATES, iterations, strict=True)), {}

    def judge(grown: Grown, sheets: list, tasks: list, predictor: str, modes: int) -> Judgement:
        tried[predictor, modes] = sheets
        return Judgement(predictor, modes, 10, told[predictor, modes], 10)

    monkeypatch.setattr(predictors, "_judge", judge)
    atlas, rows = build_atlas(grown, [0, 1])
    assert atlas.sheets == tuple(tried[winner])
    assert [row.iterations_mean for row in rows] == list(iterations)


def test_the_table_is_plain_data(judged: tuple) -> None:
    rows = json.loads(json.dumps(table(judged), allow_nan=False))
    assert len(rows) == len(CANDIDATES)
    assert set(rows[0]) == {"predictor", "modes", "tasks", "iterations_mean", "converged"}


def test_equal_nodes_give_equal_atlases(grown: Grown, parts: Parts) -> None:
    again, _ = build_atlas(grown, [0, 1])
    for mine, theirs in zip(again.sheets, parts.atlas.sheets, strict=True):
        np.testing.assert_array_equal(mine.coordinates, theirs.coordinates)
        np.testing.assert_array_equal(mine.modes, theirs.modes)


def test_a_sheet_holds_its_nodes_along_orthonormal_modes(grown: Grown) -> None:
    errors = []
    for modes in MODES:
        sheet = predictors._sheet(grown, 1, 7, modes)
        assert (sheet.gait, sheet.pattern, len(sheet.modes)) == (7, "0110/1100", modes)
        np.testing.assert_allclose(sheet.modes @ sheet.modes.T, np.eye(modes), atol=1e-5)
        nodes = [grown.nodes[1][tuple(place)] for place in sheet.places.tolist()]
        assert len(nodes) == len(grown.nodes[1])
        assert sheet.costs.tolist() == [node.cost for node in nodes]
        exact = np.array([sheet.space.encode(node.point) for node in nodes])
        errors.append(np.abs(sheet.mean + sheet.coordinates @ sheet.modes - exact).mean())
    assert errors[0] > errors[1] > errors[2]
    spread = np.abs(exact - exact.mean(axis=0)).mean()
    assert errors[2] < 0.05 * spread


def test_fewer_nodes_than_modes_are_kept_whole(grown: Grown) -> None:
    three = dict(sorted(grown.nodes[0].items())[:3])
    sheet = predictors._sheet(replace(grown, nodes=(three, {})), 0, 0, 48)
    assert len(sheet.modes) <= 3
    exact = np.array([sheet.space.encode(node.point) for _, node in sorted(three.items())])
    np.testing.assert_allclose(sheet.mean + sheet.coordinates @ sheet.modes, exact, atol=1e-3)


def test_a_node_that_ran_away_is_taken_from_its_neighbours(grown: Grown) -> None:
    place = sorted(grown.nodes[1])[len(grown.nodes[1]) // 2]
    node = grown.nodes[1][place]
    runaway = Node(node.cost, replace(node.point, rows=node.point.rows + 1e6))
    spoilt = replace(grown, nodes=(grown.nodes[0], grown.nodes[1] | {place: runaway}))
    clean, found = predictors._sheet(grown, 1, 1, 48), predictors._sheet(spoilt, 1, 1, 48)
    row = sorted(grown.nodes[1]).index(place)
    (before, after) = (each.mean + each.coordinates[row] @ each.modes for each in (clean, found))
    assert np.abs(after - before).max() < 1e3, "the runaway is gone"
    assert found.tear < 2 * clean.tear


def test_patterns_without_nodes_have_no_sheet(grown: Grown) -> None:
    few = dict(sorted(grown.nodes[1].items())[:30])
    atlas, rows = build_atlas(replace(grown, nodes=({}, few)), [5, 3])
    assert [(sheet.gait, sheet.pattern) for sheet in atlas.sheets] == [(3, "0110/1100")]
    assert (atlas.speeds, atlas.barrier) == (grown.speeds, BARRIER)
    assert rows[0].tasks > 0


@pytest.mark.parametrize("count", [0, 1])
def test_nodes_too_few_to_judge_make_an_atlas_all_the_same(grown: Grown, count: int) -> None:
    few = dict(sorted(grown.nodes[1].items())[:count])
    atlas, rows = build_atlas(replace(grown, nodes=({}, few)), [0, 1])
    assert len(atlas.sheets) == count
    assert {(row.tasks, row.iterations_mean) for row in rows} == {(0, float(LIMIT))}
    json.dumps(table(rows), allow_nan=False)
    for sheet in atlas.sheets:
        ((i, j),) = sheet.places.tolist()
        found = atlas.predict(0, atlas.speeds[i], atlas.cycle_durations[j])
        (node,) = few.values()
        np.testing.assert_allclose(found.point, sheet.space.encode(node.point), rtol=1e-5, atol=1e-5)


def test_judged_tasks_lie_amid_nodes_and_are_none(grown: Grown, parts: Parts) -> None:
    for number, nodes in enumerate(grown.nodes):
        tasks = predictors._judged(grown, number)
        assert 10 < len(tasks) <= predictors.JUDGED
        for speed, duration in tasks:
            assert speed not in grown.speeds and duration not in grown.cycle_durations
            costs, share = parts.atlas.costs(speed, duration)
            assert share[number] == pytest.approx(1.0) and costs[number] > 0
        assert len(nodes) > len(tasks)


GRID = np.array([[i, j] for i in range(6) for j in range(5)], dtype=float)


def surface(tasks: np.ndarray) -> np.ndarray:
    v, t = tasks.T
    return np.column_stack([1 + v - 2 * t, v**3 - v * t**2, t**2])


def test_the_mean_is_over_the_gaits_own_region() -> None:
    coordinates, own = surface(GRID), GRID[:, 0] < 2
    predicted = FAMILIES["mean"](GRID, coordinates, own)(GRID)
    np.testing.assert_allclose(predicted, np.tile(coordinates[own].mean(axis=0), (len(GRID), 1)))


def test_the_cubic_finds_a_cubic_between_the_nodes() -> None:
    between = GRID[:-6] + 0.4
    predicted = FAMILIES["cubic"](GRID, surface(GRID), np.ones(len(GRID), bool))(between)
    np.testing.assert_allclose(predicted, surface(between), atol=1e-8)


def test_the_kernel_finds_a_plane_and_smooths_what_is_rough() -> None:
    everything = np.ones(len(GRID), bool)
    plane = surface(GRID)[:, :1]
    np.testing.assert_allclose(FAMILIES["kernel"](GRID, plane, everything)(GRID), plane, atol=1e-8)
    rough = plane + np.where(GRID.sum(axis=1) % 2, 1.0, -1.0)[:, None]
    predicted = FAMILIES["kernel"](GRID, rough, everything)(GRID)
    assert np.abs(predicted - plane).mean() < 0.7 * np.abs(rough - plane).mean()


@pytest.mark.parametrize("tasks", [GRID[:3], GRID[:5], GRID[::5]])
def test_the_kernel_leaves_few_or_aligned_nodes_as_they_are(tasks: np.ndarray) -> None:
    coordinates = surface(tasks)
    predicted = FAMILIES["kernel"](tasks, coordinates, np.ones(len(tasks), bool))(tasks)
    np.testing.assert_array_equal(predicted, coordinates)


def test_the_atlas_of_no_pattern_is_empty(grown: Grown) -> None:
    atlas, rows = build_atlas(replace(grown, patterns=(), methods=(), nodes=()), [])
    assert atlas == Atlas(grown.speeds, grown.cycle_durations, BARRIER, ())
    assert len(rows) == len(CANDIDATES)
