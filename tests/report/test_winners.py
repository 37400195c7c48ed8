from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from gaitflow.dataset import load_solutions
from gaitflow.dataset.labels_file import read_labels
from gaitflow.report.stored import scenario_of
from gaitflow.report.winners import by_size, central, mean_phase_fractions, most_common_pattern, trajectory_of, winners


def test_every_solved_task_finds_its_solution_in_legend_order(labels, solutions, space) -> None:
    regions = winners(labels, reversed(solutions), space)
    assert list(regions) == ["walking", "gallop-walk", "pronking", "gallop", "gallop-bound", "bounding"]
    counts = labels[labels["status"] == "solved"]["gait"].value_counts()
    assert {name: len(region) for name, region in regions.items()} == counts.to_dict()
    assert all(a.task.speed <= b.task.speed for r in regions.values() for a, b in pairwise(r))


def test_gaits_by_size_count_the_tasks_they_win(labels) -> None:
    found = by_size(labels, ["gallop", "gallop-pronk"])
    counts = labels[labels["status"] == "solved"]["gait"].value_counts()
    assert [counts.get(name, 0) for name in found] == [*sorted(counts, reverse=True), 0]
    assert found[0] == "gallop" and found[-1] == "gallop-pronk"
    assert by_size(labels[labels["status"] != "solved"]) == ()


def test_a_stored_dataset_has_the_same_winners_as_its_rows() -> None:
    folder = Path(__file__).parents[2] / "datasets/half-cheetah-flat-effort/1.0.0"
    solutions, labels = load_solutions(folder), read_labels(folder).to_pandas()
    space = scenario_of(solutions).tasks.space
    stored, rows = winners(labels, solutions, space), winners(labels, list(solutions), space)
    assert {name: [motion.task for motion in region] for name, region in stored.items()} == {
        name: [motion.task for motion in region] for name, region in rows.items()
    }
    pairs = [pair for name in rows for pair in zip(stored[name], rows[name], strict=True)]
    assert pairs and all(one.pattern == other.pattern and one.cost == other.cost for one, other in pairs)
    np.testing.assert_array_equal(pairs[0][0].base, pairs[0][1].base)


def test_of_two_solves_of_one_pattern_the_cheaper_is_taken(labels, solutions, space) -> None:
    cheaper = replace(solutions[0], cost=solutions[0].cost / 2)
    dearer = replace(solutions[0], cost=solutions[0].cost * 2)
    found = winners(labels, [dearer, cheaper, *solutions], space)["walking"]
    assert found[0] is cheaper
    assert dearer not in found


def test_a_gait_without_stored_trajectories_has_an_empty_region(labels, solutions, space) -> None:
    bare = [replace(s, trajectory=None) if s.gait == "0001/0100" else s for s in solutions]
    assert winners(labels, bare, space)["bounding"] == []
    with pytest.raises(ValueError, match="has no trajectory to draw"):
        trajectory_of(bare[-1])


def test_only_the_most_common_pattern_is_averaged(solution_of) -> None:
    one, two = solution_of(0.5, 0.8, "gallop-walk"), solution_of(0.7, 1.2, "gallop-walk")
    other = replace(solution_of(0.6, 1.0, "gallop-walk"), pattern="0001/0011")
    assert most_common_pattern([other, one, two]) == [one, two]
    fractions = mean_phase_fractions([one, two])
    expected = (one.trajectory.durations / 0.8 + two.trajectory.durations / 1.2) / 2
    np.testing.assert_allclose(fractions, expected, rtol=1e-12)
    assert fractions.sum() == pytest.approx(1)


def test_the_central_solution_lies_in_the_middle_of_its_region(solution_of) -> None:
    region = [solution_of(v, t, "gallop") for v in (0.9, 1.5, 2.1) for t in (0.4, 1.0, 1.6)]
    middle = central(region)
    assert (middle.task.speed, middle.task.cycle_duration) == (1.5, 1.0)
    assert central(region[:1]) is region[0]
