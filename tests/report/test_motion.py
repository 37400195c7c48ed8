from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_hex

from gaitflow.report.motion import SNAPSHOTS, draw_motion
from gaitflow.report.snapshot import BODY_COLOUR, FLOOR_COLOUR, GROUND_COLOUR, SWING_COLOUR

COLOUR = "#D55E00"


def lines_of(axes, colour: str) -> list[np.ndarray]:
    found = [line for line in axes.lines if to_hex(line.get_color()) == colour.lower()]
    return [line.get_xydata() for line in found if len(line.get_xydata()) == 2]


def bodies_of(axes) -> list[np.ndarray]:
    """Outlines of the bodies, without their upper sides."""
    return [patch.get_xy()[:-1] for patch in axes.patches if to_hex(patch.get_facecolor()) == BODY_COLOUR]


def test_snapshots_show_the_stored_states(solution_of, scenario) -> None:
    solution = solution_of(1.5, 0.8, "gallop")
    strip, bars = draw_motion(solution, scenario, "gallop", COLOUR).axes
    bodies, trajectory = bodies_of(strip), solution.trajectory
    assert len(bodies) == SNAPSHOTS
    for place, body in enumerate(bodies):
        time = (place + 0.5) / SNAPSHOTS * 0.8
        z, pitch = (np.interp(time, trajectory.times, trajectory.base[:, column]) for column in (1, 2))
        assert body[:, 1].mean() == pytest.approx(z)
        order = np.argsort(body[:, 0])
        hind, front = body[order[:2]].mean(axis=0), body[order[2:]].mean(axis=0)
        assert np.arctan2(*(front - hind)[::-1]) == pytest.approx(pitch)  # nose up is positive
        assert np.hypot(*(front - hind)) == pytest.approx(1.0)
    assert bars.get_xlim() == pytest.approx((0, 0.8))


def test_standing_legs_and_their_forces_are_those_of_the_pattern(solution_of, scenario) -> None:
    solution = solution_of(1.5, 0.8, "gallop")
    strip, _ = draw_motion(solution, scenario, "gallop", COLOUR).axes
    edges = np.cumsum(solution.trajectory.durations)
    phases = [int(np.searchsorted(edges, (i + 0.5) / SNAPSHOTS * 0.8)) for i in range(SNAPSHOTS)]
    standing = sum(row[phase] == "1" for phase in phases for row in solution.pattern.split("/"))
    assert 0 < standing < 2 * SNAPSHOTS
    assert len(lines_of(strip, COLOUR)) == standing
    arrows = [item for item in strip.texts if item.arrow_patch is not None]
    assert len(arrows) == standing
    # A standing foot is on the ground.
    assert max(leg[:, 1].min() for leg in lines_of(strip, COLOUR)) == pytest.approx(0, abs=1e-12)


def test_the_ground_rises_with_the_tasks_slope(solution_of, scenario) -> None:
    solution = solution_of(1.5, 0.8, "gallop")
    steep = replace(solution, task=solution.task.replaced(slope=20.0))
    strip, _ = draw_motion(steep, scenario, "gallop", COLOUR).axes
    for start, end in lines_of(strip, GROUND_COLOUR):
        assert np.rad2deg(np.arctan2(*(end - start)[::-1])) == pytest.approx(20)


def test_the_camera_turns_with_the_command(trot, anymal) -> None:
    """A robot that turns on the spot looks the same in every snapshot, were it not for its sway."""
    turning = replace(trot, task=trot.task.replaced(speed=0.0, yaw_rate=1.0))
    turned = trot.trajectory.base.copy()
    turned[:, :2] = 0.0
    turned[:, 3:6] = np.outer(trot.trajectory.times, [1.0, 0.0, 0.0])
    still = replace(turning, trajectory=replace(trot.trajectory, base=turned))
    bodies = bodies_of(draw_motion(still, anymal, "turn", COLOUR).axes[0])
    widths = [np.ptp(body[:, 0]) for body in bodies]
    np.testing.assert_allclose(widths, widths[0], rtol=1e-9)
    unseen = replace(still, task=still.task.replaced(yaw_rate=0.0))
    widths = [np.ptp(body[:, 0]) for body in bodies_of(draw_motion(unseen, anymal, "turn", COLOUR).axes[0])]
    assert np.ptp(widths) > 0.01


def test_a_quadruped_in_space_is_drawn_with_all_its_legs_forces_and_ground(trot, anymal) -> None:
    strip, bars = draw_motion(trot, anymal, "walking trot", COLOUR).axes
    assert len(bodies_of(strip)) == SNAPSHOTS
    floors = [patch for patch in strip.patches if to_hex(patch.get_facecolor()) == FLOOR_COLOUR]
    assert len(floors) == SNAPSHOTS and all(len(patch.get_xy()) == 5 for patch in floors)
    edges = np.cumsum(trot.trajectory.durations)[:-1]
    phases = [int(np.searchsorted(edges, (i + 0.5) / SNAPSHOTS * 0.8)) for i in range(SNAPSHOTS)]
    standing = sum(row[phase] == "1" for phase in phases for row in trot.pattern.split("/"))
    assert len(lines_of(strip, COLOUR)) == standing
    assert len(lines_of(strip, SWING_COLOUR)) == 4 * SNAPSHOTS - standing > 0
    assert len([item for item in strip.texts if item.arrow_patch is not None]) == standing
    assert [label.get_text() for label in bars.get_yticklabels()] == ["LF", "RF", "LH", "RH"]


def test_a_solution_without_trajectory_is_refused(solution_of, scenario) -> None:
    with pytest.raises(ValueError, match=r"speed 1\.5 m/s, cycle_duration 0\.8 s has no trajectory"):
        draw_motion(replace(solution_of(1.5, 0.8, "gallop"), trajectory=None), scenario, "gallop", COLOUR)
