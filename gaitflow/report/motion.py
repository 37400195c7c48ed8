"""Snapshots of one motion over its cycle with contact forces, in the manner of Fig. 2 and 9, seen from the side."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from gaitflow.report.gait_diagrams import draw_contacts
from gaitflow.report.state_space import height_and_pitch
from gaitflow.report.winners import trajectory_of
from gaitflow.scenario import Scenario
from gaitflow.solve.solution import Solution
from gaitflow.trajectory import Array

SNAPSHOTS = 6
WIDTH = 8.4  # inches
GRAVITY = 9.81  # m/s^2, only for the length of the arrows
FORCE_COLOUR, GROUND_COLOUR, BODY_COLOUR, SWING_COLOUR = "#C1121F", "#8a8a8a", "#3d3d3d", "#d0d0d0"

OUTLINE = [withStroke(linewidth=3, foreground="#6b6b6b")]  # keeps a pale gait colour visible on white


def draw_motion(solution: Solution, scenario: Scenario, gait: str, colour: str) -> Figure:
    """A strip of snapshots, evenly spaced over the cycle, above the contact bars of the same time.

    The ground is drawn with its slope. An arrow half as long as the default leg is a force as large as the robot's
    weight. In space this is the view from the right, with pitch as the only angle. Raises ValueError when the
    solution has no trajectory.
    """
    trajectory, robot = trajectory_of(solution), scenario.robot
    feet = np.array([leg.default_foot for leg in robot.legs])
    height = -float(feet[:, -1].mean())
    spacing = 1.45 * max(float(np.ptp(feet[:, 0])), 2 * height)
    turn = _rotation(np.deg2rad(scenario.terrain.slope_deg))
    scale = height / (2 * robot.mass * GRAVITY)
    shares = (np.arange(SNAPSHOTS) + 0.5) / SNAPSHOTS
    lean = 0.5 * height * turn[1, 0]  # up a slope the body stands behind the ground below it
    snapshots = [
        _snapshot(solution, share, feet[:, 0], scale, 0.46 * spacing).turned(turn, spacing * (place + 0.5) + lean)
        for place, share in enumerate(shares)
    ]
    low, high = (limit(point[1] for shot in snapshots for point in shot.points) for limit in (min, max))
    low, high = low - 0.08 * height, high + 0.12 * height
    bars_height, strip_height = 0.17 * len(robot.legs), (high - low) / (SNAPSHOTS * spacing) * WIDTH
    figure = Figure(figsize=(WIDTH, strip_height + bars_height + 0.8), dpi=150, layout="constrained")
    strip, bars = figure.subplots(2, 1, height_ratios=[strip_height, bars_height])
    for snapshot in snapshots:
        snapshot.draw(strip, colour)
    strip.set_xlim(0, SNAPSHOTS * spacing)
    strip.set_ylim(low, high)
    strip.set_aspect("equal", anchor="S")
    strip.set_axis_off()
    strip.set_title(gait, fontsize=11, loc="left")
    task = f"v = {solution.speed:.3g} m/s, T = {solution.cycle_duration:.3g} s"
    strip.set_title(task, fontsize=9, loc="right", color="#555555")
    draw_contacts(bars, solution.pattern, trajectory.durations, robot.leg_names, colour)
    bars.set_xlabel("time [s]", fontsize=9)
    return figure


@dataclass(frozen=True)
class _Snapshot:
    """The robot in the side view (x forward, z up) [m]; forces are drawn as lengths [m]."""

    ground: Array  # [2, 2] ends of the ground line
    body: Array  # [2]
    hips: Array  # [legs, 2]
    feet: Array  # [legs, 2]
    tips: Array  # [legs, 2] where the arrows of the forces end
    standing: tuple[bool, ...]  # [legs]

    @property
    def points(self) -> Array:
        return np.concatenate([self.ground, self.hips, self.feet, self.tips])

    def turned(self, rotation: Array, along: float) -> _Snapshot:
        """Turned by the slope, and then moved along the page."""
        parts = ("ground", "body", "hips", "feet", "tips")
        return replace(self, **{name: getattr(self, name) @ rotation.T + [along, 0.0] for name in parts})

    def draw(self, axes: Axes, colour: str) -> None:
        axes.plot(*self.ground.T, color=GROUND_COLOUR, linewidth=1.2, solid_capstyle="butt")
        for hip, foot, tip, standing in zip(self.hips, self.feet, self.tips, self.standing, strict=True):
            shade = colour if standing else SWING_COLOUR
            axes.plot(*np.array([hip, foot]).T, color=shade, linewidth=2, solid_capstyle="round", path_effects=OUTLINE)
            axes.plot(*foot, marker="o", markersize=3.2, color=shade, path_effects=OUTLINE)
            if standing:
                style = {"arrowstyle": "-|>", "color": FORCE_COLOUR, "linewidth": 1.1, "mutation_scale": 7}
                axes.annotate("", tip, foot, arrowprops={**style, "shrinkA": 0, "shrinkB": 0}, zorder=4)
        front, hind = self.hips[:, 0].argmax(), self.hips[:, 0].argmin()
        axes.plot(*self.hips[[hind, front]].T, color=BODY_COLOUR, linewidth=6, solid_capstyle="round", zorder=3)
        axes.plot(*self.body, marker="o", markersize=2.5, color="white", zorder=5)


def _snapshot(solution: Solution, share: float, hips: Array, scale: float, half_width: float) -> _Snapshot:
    """The robot at a share of the cycle above the origin; states interpolated, forces those of the step."""
    trajectory = trajectory_of(solution)
    times = trajectory.times
    time = times[0] + share * (times[-1] - times[0])
    step = int(np.clip(np.searchsorted(times, time, side="right") - 1, 0, len(times) - 2))
    part = (time - times[step]) / max(times[step + 1] - times[step], 1e-12)

    def at(values: Array) -> Array:
        return np.asarray((1 - part) * values[step] + part * values[step + 1])

    (z, _), (pitch, _) = height_and_pitch(trajectory.base)
    # Nose up is positive in the plane; about the lateral axis in space it is negative.
    nose_up = float(at(pitch)) if trajectory.feet.shape[-1] == 2 else -float(at(pitch))
    body = np.array([0.0, float(at(z))])
    feet = at(trajectory.feet)[:, [0, -1]] - [float(at(trajectory.base[:, 0])), 0.0]
    phases = np.cumsum(trajectory.durations)[:-1]
    phase = int(np.searchsorted(phases, time - times[0], side="right"))
    return _Snapshot(
        ground=np.array([[-half_width, 0.0], [half_width, 0.0]]),
        body=body,
        hips=body + np.column_stack([hips, np.zeros_like(hips)]) @ _rotation(nose_up).T,
        feet=feet,
        tips=feet + scale * trajectory.forces[step][:, [0, -1]],
        standing=tuple(row[phase] == "1" for row in solution.pattern.split("/")),
    )


def _rotation(angle: float) -> Array:
    """Rotation of the plane by an angle [rad] from x to z: nose up."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])
