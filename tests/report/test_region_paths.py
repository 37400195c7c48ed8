from __future__ import annotations

import re

import numpy as np
import pytest

from gaitflow.report.region_paths import outline, region_paths


def painted(path: str, shape: tuple[int, int]) -> np.ndarray:
    """How often the path's rectangles cover each cell."""
    covered = np.zeros(shape, dtype=int)
    for x, y, width, height in re.findall(r"M(\d+) (\d+)h(\d+)v(\d+)h-\3z", path):
        covered[int(y) : int(y) + int(height), int(x) : int(x) + int(width)] += 1
    return covered


def test_the_outline_covers_every_cell_inside_once() -> None:
    rng = np.random.default_rng(3)
    for share in (0.0, 0.2, 0.7, 1.0):
        inside = rng.random((13, 9)) < share
        np.testing.assert_array_equal(painted(outline(inside), inside.shape), inside)


def test_a_rectangle_is_one_piece() -> None:
    inside = np.zeros((6, 5), dtype=bool)
    inside[2:5, 1:4] = True
    assert outline(inside) == "M1 2h3v3h-3z"


def test_cells_are_asked_for_at_their_middles_and_y_rises() -> None:
    asked = []

    def select(values):
        asked.append(values)
        return np.where(values["cycle_duration"] > 1.0, np.where(values["speed"] > 1.5, -1, 1), 0)

    axes = {"speed": (0.0, 2.0), "cycle_duration": (0.5, 1.5)}
    paths = region_paths(select, axes, {"slope": 5.0}, 4, ["walking", "gallop"])
    assert paths == {"walking": "M0 0h4v2h-4z", "gallop": "M0 2h3v2h-3z"}
    np.testing.assert_allclose(sorted({v for values in asked for v in values["speed"]}), [0.25, 0.75, 1.25, 1.75])
    assert {v for values in asked for v in values["slope"]} == {5.0}


def test_of_one_axis_each_decision_is_asked_for_once_and_fills_the_height() -> None:
    counts = []

    def select(values):
        counts.append(len(values["speed"]))
        return (values["speed"] > 1.0).astype(int)

    assert region_paths(select, {"speed": (0.0, 2.0)}, {}, 4, ["a", "b"]) == {"a": "M0 0h2v4h-2z", "b": "M2 0h2v4h-2z"}
    assert sum(counts) == 4


def test_an_answer_that_is_no_gait_is_refused() -> None:
    axes = {"speed": (0.0, 1.0), "cycle_duration": (0.0, 1.0)}
    with pytest.raises(ValueError, match="answered 2 to 2, but the gaits are numbered 0 to 1"):
        region_paths(lambda values: np.full(len(values["speed"]), 2), axes, {}, 4, ["a", "b"])
