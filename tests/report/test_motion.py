from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_hex

from gaitflow.report.motion import BODY_COLOUR, GROUND_COLOUR, SNAPSHOTS, draw_motion
from gaitflow.robots import Leg, Robot
from gaitflow.scenario import Terrain
from gaitflow.trajectory import Trajectory

COLOUR = "#D55E00"


def lines_of(axes, colour: str) -> list[np.ndarray]:
    found = [line for line in axes.lines if to_hex(line.get_color()) == colour.lower()]
    return [line.get_xydata() for line in found if len(line.get_xydata()) == 2]


def test_snapshots_show_the_stored_states(solution_of, scenario) -> None:
    solution = solution_of(1.5, 0.8, "gallop")
    strip, bars = draw_motion(solution, scenario, "gallop", COLOUR).axes
    bodies, trajectory = lines_of(strip, BODY_COLOUR), solution.trajectory
    assert len(bodies) == SNAPSHOTS
    for place, body in enumerate(bodies):
        time = (place + 0.5) / SNAPSHOTS * 0.8
        z, pitch = (np.interp(time, trajectory.times, trajectory.base[:, column]) for column in (1, 2))
        assert body[:, 1].mean() == pytest.approx(z)
        hind, front = body
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


def test_the_ground_rises_with_the_slope(solution_of, scenario) -> None:
    steep = scenario.model_copy(update={"terrain": Terrain(slope_deg=20.0)})
    strip, _ = draw_motion(solution_of(1.5, 0.8, "gallop"), steep, "gallop", COLOUR).axes
    for start, end in lines_of(strip, GROUND_COLOUR):
        assert np.rad2deg(np.arctan2(*(end - start)[::-1])) == pytest.approx(20)


def test_a_quadruped_in_space_is_seen_from_the_side(solution_of, scenario) -> None:
    plane = solution_of(1.5, 0.8, "gallop")
    flat = plane.trajectory
    feet, forces = (np.insert(np.repeat(values, 2, axis=1), 1, 0.2, axis=2) for values in (flat.feet, flat.forces))
    base = np.zeros((len(flat.base), 12))
    base[:, [0, 2, 6, 8]] = flat.base[:, [0, 1, 3, 4]]
    base[:, [4, 10]] = -flat.base[:, [2, 5]]  # about y, to the left, nose up is negative
    legs = [
        Leg(name=name, default_foot=(x, y, -0.5))
        for name, x, y in (("LF", 0.5, 0.2), ("RF", 0.5, -0.2), ("LH", -0.5, 0.2), ("RH", -0.5, -0.2))
    ]
    inertia = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    box = (0.2, 0.1, 0.2)
    fields = {"dimension": 3, "legs": tuple(legs), "inertia": inertia, "box": box}
    robot = Robot(**{**{name: getattr(scenario.robot, name) for name in Robot.model_fields}, **fields})
    space = Trajectory(flat.times, base, feet, forces, forces, flat.durations)
    rows = plane.pattern.split("/")
    solution = replace(plane, trajectory=space, pattern="/".join([rows[0], rows[0], rows[1], rows[1]]))
    in_plane, _ = draw_motion(plane, scenario, "gallop", COLOUR).axes
    in_space, bars = draw_motion(solution, scenario.model_copy(update={"robot": robot}), "gallop", COLOUR).axes
    np.testing.assert_allclose(lines_of(in_space, BODY_COLOUR), lines_of(in_plane, BODY_COLOUR), atol=1e-12)
    assert [label.get_text() for label in bars.get_yticklabels()] == ["LF", "RF", "LH", "RH"]


def test_a_solution_without_trajectory_is_refused(solution_of, scenario) -> None:
    with pytest.raises(ValueError, match=r"1\.5 m/s, 0\.8 s has no trajectory"):
        draw_motion(replace(solution_of(1.5, 0.8, "gallop"), trajectory=None), scenario, "gallop", COLOUR)
