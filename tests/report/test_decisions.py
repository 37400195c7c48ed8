from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from gaitflow.report.decisions import decisions

Cells = NDArray[np.intp]


class Painted:
    """Answers with the cells of a picture, and counts how often each was asked for."""

    def __init__(self, cells: Cells) -> None:
        self.cells = cells
        self.asked = np.zeros_like(cells)

    def __call__(self, values: Mapping[str, NDArray[np.float64]]) -> Cells:
        assert set(values["slope"]) == {5.0}
        row, column = values["cycle_duration"].astype(int), values["speed"].astype(int)
        np.add.at(self.asked, (row, column), 1)
        return self.cells[row, column]

    def drawn(self) -> Cells:
        rows, columns = self.cells.shape
        along = {"speed": np.arange(columns, dtype=float), "cycle_duration": np.arange(rows, dtype=float)}
        return decisions(self, along, {"slope": 5.0}, 9)


def two_cells_wide(cells: Cells) -> NDArray[np.bool_]:
    """Which cells lie in a block of two by two alike."""
    wide = np.zeros(cells.shape, dtype=bool)
    parts = [(rows, columns) for rows in (slice(-1), slice(1, None)) for columns in (slice(-1), slice(1, None))]
    alike = np.all([cells[part] == cells[:-1, :-1] for part in parts], axis=0)
    for part in parts:
        wide[part] |= alike
    return wide


@given(st.integers(0, 10_000), st.integers(3, 40), st.integers(3, 40), st.integers(1, 5))
def test_no_region_of_two_cells_or_more_each_way_is_missed(seed: int, rows: int, columns: int, rectangles: int) -> None:
    generator = np.random.default_rng(seed)
    cells = np.full((rows, columns), -1)
    for gait in range(rectangles):
        row, column = generator.integers(0, rows - 1), generator.integers(0, columns - 1)
        height, width = generator.integers(2, [rows - row + 1, columns - column + 1])
        cells[row : row + height, column : column + width] = gait
    painted = Painted(cells)
    differ = painted.drawn() != cells
    assert painted.asked.max() == 1
    assert not (differ & two_cells_wide(cells)).any()


def test_most_cells_inside_regions_are_not_asked_for() -> None:
    row, column = np.indices((200, 200))
    cells = (row + 2 * column > 270).astype(int) + (row > 150)
    painted = Painted(cells)
    np.testing.assert_array_equal(painted.drawn(), cells)
    assert 0.25 < painted.asked.mean() < 0.3


def test_where_every_cell_differs_all_are_asked_for() -> None:
    cells = np.arange(99).reshape(9, 11) % 7
    painted = Painted(cells)
    np.testing.assert_array_equal(painted.drawn(), cells)
    assert painted.asked.all()


def test_one_axis_is_one_row() -> None:
    found = decisions(lambda values: (values["speed"] > 1.0).astype(int), {"speed": np.linspace(0, 2, 9)}, {}, 2)
    np.testing.assert_array_equal(found, [[0, 0, 0, 0, 0, 1, 1, 1, 1]])


@pytest.mark.parametrize("index", [-2, 2])
def test_an_index_that_is_no_gait_is_refused(index: int) -> None:
    with pytest.raises(ValueError, match=f"select answered {index} to {index}, but the gaits are numbered 0 to 1"):
        decisions(lambda values: np.full(len(values["speed"]), index), {"speed": np.arange(3.0)}, {}, 2)
