"""Snapshots of one motion over its cycle with contact forces, in the manner of Fig. 2 and 9."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from scipy.spatial import ConvexHull, QhullError

from gaitflow.config.scenario import Scenario
from gaitflow.core.trajectory import Array
from gaitflow.report import axis_text
from gaitflow.report.gait_diagrams import draw_contacts
from gaitflow.report.scene import Pose, Scene, camera, rotation_of, scene_of
from gaitflow.search.solution import Solution

SNAPSHOTS = 6
WIDTH = 8.4  # inches
VIEW = (0.45, 0.3)  # rad: azimuth and elevation of the camera for a robot in space
FORCE_COLOUR, GROUND_COLOUR, BODY_COLOUR, SWING_COLOUR = "#C1121F", "#8a8a8a", "#3d3d3d", "#d0d0d0"
FLOOR_COLOUR, TOP_COLOUR = "#f1f1ef", "#6a6a6a"

OUTLINE = [withStroke(linewidth=3, foreground="#6b6b6b")]  # keeps a pale gait colour visible on white


def draw_motion(solution: Solution, scenario: Scenario, gait: str, colour: str) -> Figure:
    """A strip of snapshots, evenly spaced over the cycle, above the contact bars of the same time.

    A planar robot is seen from its right side, a robot in space from above its right front. The ground is drawn with
    its slope. An arrow as long as the default leg, in the plane half as long, is a force as large as the robot's
    weight. Raises ValueError when the solution has no trajectory.
    """
    scene = scene_of(solution, scenario)
    view = (camera(0.0, 0.0) if scene.planar else camera(*VIEW)) @ _slope(scene.slope)
    body = scene.body @ view.T
    spacing = 1.45 * max(float(np.ptp(body[:, 0])), 2 * scene.height)
    lean = 0.5 * scene.height * np.sin(scene.slope)  # up a slope the body stands behind the ground below it
    times = (np.arange(SNAPSHOTS) + 0.5) / SNAPSHOTS * scene.times[-1]
    turns = np.interp(times, scene.times, scene.headings)  # the camera turns with the command
    shots = [
        _shot(
            scene, scene.at(time), view @ rotation_of(np.array([-turn, 0.0, 0.0])), spacing * (place + 0.5) + lean,
            0.46 * spacing,
        )
        for place, (time, turn) in enumerate(zip(times, turns, strict=True))
    ]  # fmt: skip
    low, high = (limit(float(limit(shot.points[:, 1])) for shot in shots) for limit in (min, max))
    low, high = low - 0.08 * scene.height, high + 0.12 * scene.height
    bars_height, strip_height = 0.17 * len(scene.rows), (high - low) / (SNAPSHOTS * spacing) * WIDTH
    figure = Figure(figsize=(WIDTH, strip_height + bars_height + 0.8), dpi=150, layout="constrained")
    strip, bars = figure.subplots(2, 1, height_ratios=[strip_height, bars_height])
    for shot in shots:
        shot.draw(strip, colour)
    strip.set_xlim(0, SNAPSHOTS * spacing)
    strip.set_ylim(low, high)
    strip.set_aspect("equal", anchor="S")
    strip.set_axis_off()
    strip.set_title(gait, fontsize=11, loc="left")
    task = axis_text.values(solution.task, scenario.tasks.space.columns)
    strip.set_title(task, fontsize=9, loc="right", color="#555555")
    draw_contacts(bars, solution.pattern, scene.durations, scenario.robot.leg_names, colour)
    for time in times:
        bars.plot(time, -0.5, marker="v", markersize=4, color=BODY_COLOUR, clip_on=False)
    bars.set_xlabel("time [s]", fontsize=9)
    return figure


@dataclass(frozen=True)
class _Shot:
    """One pose on the page: x to the right, y up [m]; forces are drawn as lengths [m]."""

    floor: Array  # [2 or 4, 2] the ground's line, or its corners
    body: Array  # [corners, 2] outline of the body
    top: Array  # [4, 2] its upper side
    hips: Array  # [legs, 2]
    feet: Array  # [legs, 2]
    tips: Array  # [legs, 2] where the arrows of the forces end
    near: Array  # [legs] how near the camera each leg is
    standing: tuple[bool, ...]  # [legs]

    @property
    def points(self) -> Array:
        return np.concatenate([self.floor, self.body, self.hips, self.feet, self.tips])

    def draw(self, axes: Axes, colour: str) -> None:
        if len(self.floor) == 2:
            axes.plot(*self.floor.T, color=GROUND_COLOUR, linewidth=1.2, solid_capstyle="butt")
        else:
            axes.fill(*self.floor.T, facecolor=FLOOR_COLOUR, edgecolor=GROUND_COLOUR, linewidth=0.6, zorder=1)
        middle = float(np.median(self.near))
        for leg in np.argsort(self.near):  # the far legs first
            shade = colour if self.standing[leg] else SWING_COLOUR
            line = np.array([self.hips[leg], self.feet[leg]])
            front = 4.0 if self.near[leg] > middle else 2.0  # of the body
            axes.plot(*line.T, color=shade, linewidth=2, solid_capstyle="round", path_effects=OUTLINE, zorder=front)
            axes.plot(*self.feet[leg], marker="o", markersize=3.2, color=shade, path_effects=OUTLINE, zorder=front)
            if self.standing[leg]:
                style = {"arrowstyle": "-|>", "color": FORCE_COLOUR, "linewidth": 1.1, "mutation_scale": 7}
                arrow = {**style, "shrinkA": 0, "shrinkB": 0}
                axes.annotate("", self.tips[leg], self.feet[leg], arrowprops=arrow, zorder=5)
        for face, shade in ((self.body, BODY_COLOUR), (self.top, TOP_COLOUR)):
            axes.fill(*face.T, facecolor=shade, edgecolor=BODY_COLOUR, linewidth=1.5, joinstyle="round", zorder=3)


def _shot(scene: Scene, pose: Pose, view: Array, along: float, half_width: float) -> _Shot:
    """The pose on the page, the ground below the base at `along`."""
    below = pose.position * [1.0, 1.0, 0.0]

    def page(points: Array) -> Array:
        return np.asarray((points - below) @ view[:2].T + [along, 0.0])

    if scene.planar:
        ground = np.array([[-half_width, 0, 0], [half_width, 0, 0]])
    else:
        x, y = 0.5 * np.ptp(scene.hips, axis=0)[:2] + 0.25 * scene.height
        ground = np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]])
    arrows = (0.5 if scene.planar else 1.0) * scene.height / scene.weight * pose.forces
    corners = page(pose.position + scene.body @ pose.rotation.T)
    return _Shot(
        floor=page(below + ground),
        body=_outline(corners),
        top=corners[[4, 5, 7, 6]],
        hips=page(pose.hips),
        feet=page(pose.feet),
        tips=page(pose.feet + arrows),
        near=(pose.hips - below) @ view[2],
        standing=pose.standing,
    )


def _outline(corners: Array) -> Array:
    """The convex outline [n, 2] of points on the page; a flat body's is its points."""
    try:
        return np.asarray(corners[ConvexHull(corners).vertices])
    except QhullError:
        return corners


def _slope(angle: float) -> Array:
    """[3, 3] terrain frame to a level one: the ground rises forward by `angle` [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
