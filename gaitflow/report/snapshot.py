"""One pose of a robot on a page: body, legs, the ground below and the forces of the legs that stand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from scipy.spatial import ConvexHull, QhullError

from gaitflow.core.trajectory import Array
from gaitflow.report.scene import Pose, Scene, camera, rotation_of

VIEW = (0.45, 0.3)  # rad: azimuth and elevation of the camera for a robot in space
FORCE_COLOUR, GROUND_COLOUR, BODY_COLOUR, SWING_COLOUR = "#C1121F", "#8a8a8a", "#3d3d3d", "#d0d0d0"
FLOOR_COLOUR, TOP_COLOUR = "#f1f1ef", "#6a6a6a"

OUTLINE = [withStroke(linewidth=3, foreground="#6b6b6b")]  # keeps a pale gait colour visible on white


def view_of(scene: Scene, heading: float = 0.0) -> Array:
    """[3, 3] world to page for a command that faces `heading` [rad]; the ground rises forward by the task's slope.

    A planar robot is seen from its right side, a robot in space from above its right front.
    """
    level = camera(0.0, 0.0) if scene.planar else camera(*VIEW)
    return np.asarray(level @ _slope(scene.slope) @ rotation_of(np.array([-heading, 0.0, 0.0])))


@dataclass(frozen=True)
class Snapshot:
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
        """Everything that has to fit on the page [n, 2]."""
        return np.concatenate([self.floor, self.body, self.hips, self.feet, self.tips])

    def draw(self, axes: Axes, colour: str) -> None:
        """Draw it; standing legs in `colour`."""
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


def snapshot(scene: Scene, pose: Pose, view: Array, origin: Array, along: float, half_width: float) -> Snapshot:
    """The pose on the page; `origin` [3], a point of the ground, comes to (along, 0).

    An arrow as long as the default leg, in the plane half as long, is a force as large as the robot's weight.
    `half_width` [m] is that of the drawn ground in the plane.
    """

    def page(points: Array) -> Array:
        return np.asarray((points - origin) @ view[:2].T + [along, 0.0])

    if scene.planar:
        ground = np.array([[-half_width, 0, 0], [half_width, 0, 0]])
    else:
        x, y = 0.5 * np.ptp(scene.hips, axis=0)[:2] + 0.25 * scene.height
        ground = np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]])
    arrows = (0.5 if scene.planar else 1.0) * scene.height / scene.weight * pose.forces
    corners = page(pose.position + scene.body @ pose.rotation.T)
    return Snapshot(
        floor=page(origin + ground),
        body=_outline(corners),
        top=corners[[4, 5, 7, 6]],
        hips=page(pose.hips),
        feet=page(pose.feet),
        tips=page(pose.feet + arrows),
        near=(pose.hips - origin) @ view[2],
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
