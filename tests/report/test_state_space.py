from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import same_color

from gaitflow.report.state_space import MEAN_COLOUR, draw_state_space, planes


def test_columns_in_the_plane_and_in_space() -> None:
    plane = np.arange(6.0)[None]
    assert [[float(v[0]) for v in pair] for pair in planes(plane)] == [[1, 4], [2, 5]]
    space = np.arange(12.0)[None]  # x y z, yaw pitch roll, their velocities, omega x y z
    assert [[float(v[0]) for v in pair] for pair in planes(space)] == [[2, 8], [4, 10], [5, 9]]


def test_another_width_is_refused() -> None:
    with pytest.raises(ValueError, match=r"7 columns; 6 \(plane\) or 12 \(space\) are expected"):
        planes(np.zeros((3, 7)))


def test_the_bold_line_is_the_mean_of_the_region(solution_of, space) -> None:
    region = [solution_of(v, 0.8, "gallop") for v in (0.9, 1.5, 2.1)]
    figure = draw_state_space({"gallop": region, "bounding": []}, space)
    height, pitch, _colour_bar = figure.axes
    for axes, columns in ((height, (1, 4)), (pitch, (2, 5))):
        (mean,) = [line for line in axes.lines if same_color(line.get_color(), MEAN_COLOUR)]
        expected = np.mean([solution.trajectory.base[:, columns] for solution in region], axis=0)
        np.testing.assert_allclose(mean.get_xydata(), expected)
        assert len(axes.lines) == 3 + 2  # a line a task, the mean and its outline


def test_the_mean_leaves_out_tasks_of_another_pattern(solution_of, space) -> None:
    region = [solution_of(v, 0.8, "gallop") for v in (0.9, 1.5)]
    odd = replace(solution_of(2.1, 0.8, "gallop"), pattern="0011/0110")
    axes = draw_state_space({"gallop": [odd, *region]}, space).axes[0]
    (mean,) = [line for line in axes.lines if same_color(line.get_color(), MEAN_COLOUR)]
    expected = np.mean([solution.trajectory.base[:, [1, 4]] for solution in region], axis=0)
    np.testing.assert_allclose(mean.get_xydata(), expected)


def test_one_row_a_gait(solution_of, space) -> None:
    regions = {name: [solution_of(0.5, 0.8, name)] for name in ("walking", "gallop")}
    figure = draw_state_space(regions, space)
    assert [axes.get_title(loc="left") for axes in figure.axes[:4:2]] == ["walking", "gallop"]


def test_no_trajectory_at_all_is_refused(space) -> None:
    with pytest.raises(ValueError, match="no gait has a stored trajectory"):
        draw_state_space({}, space)


def test_a_robot_in_space_rolls_too(trot, solved, space) -> None:
    region = [trot, solved(0.2, 0.8, trot.pattern)]
    figure = draw_state_space({"walking trot": region}, space)
    assert [axes.get_xlabel() for axes in figure.axes[:3]] == ["height z [m]", "pitch [rad]", "roll [rad]"]
    (mean,) = [line for line in figure.axes[2].lines if same_color(line.get_color(), MEAN_COLOUR)]
    expected = np.mean([solution.trajectory.base[:, [5, 9]] for solution in region], axis=0)
    np.testing.assert_allclose(mean.get_xydata(), expected)
