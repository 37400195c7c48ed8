"""A walk as one picture: poses over a cycle in a row, and under them who stood when, planned and simulated."""

from __future__ import annotations

from io import BytesIO

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitflow.core.trajectory import Array
from gaitflow.report.gait_diagrams import BAR, draw_contacts
from gaitflow.report.scene import camera
from gaitflow.report.snapshot import BODY_COLOUR, FLOOR_COLOUR, FORCE_COLOUR, GROUND_COLOUR, SWING_COLOUR
from gaitflow.report.walk_scene import EDGES, WalkScene

POSES = 7
VIEW = (0.35, 0.18)  # rad: azimuth and elevation of the camera
WIDTH = 11.0  # inches


def walk_strip(scene: WalkScene, title: str, colour: str) -> bytes:
    """A PNG of the last whole cycle of a walk; of a robot that fell before, its last moments.

    A foot that carries has the gait's hex colour and its force as an arrow: as long as the body is high where it is
    the robot's weight. In the bars the plan's stances are solid, and dark lines are the simulated ones.
    """
    period = float(scene.durations.sum())
    last = max(float(scene.times[-1]), 1e-9)
    start = max((last // period - 1) * period, 0.0) if last >= period else 0.0
    times = start + np.arange(POSES) / (POSES - 1) * min(period, last)
    figure = Figure(figsize=(WIDTH, 3.5), dpi=120, layout="constrained")
    stage, bars = figure.subplots(2, 1, height_ratios=[1.4, 1.0])
    view = camera(*VIEW)
    spacing = 2.3 * max(float(np.ptp(scene.body[0, :, 0])), scene.height)
    for place, time in enumerate(times):
        moment = int(np.abs(scene.times - time).argmin())
        _draw_pose(stage, scene, moment, view, place * spacing, colour)
        stage.text(
            place * spacing, -0.55 * scene.height, f"{time - start:.2f} s", ha="center", fontsize=9, color="#555555"
        )
    stage.axis("off")
    stage.set_aspect("equal")
    stage.set_title(title, fontsize=10, loc="left")
    draw_contacts(bars, "/".join(scene.planned), scene.durations, scene.leg_names, colour)
    _draw_touching(bars, scene, start)
    for time in times:
        bars.axvline(time - start, color="#999999", linewidth=0.6)
    bars.set_xlabel("time [s]", fontsize=9)
    picture = BytesIO()
    figure.savefig(picture, format="png")
    return picture.getvalue()


def _draw_pose(axes: Axes, scene: WalkScene, moment: int, view: Array, shift: float, colour: str) -> None:
    under = np.array([*scene.middle[moment, :2], scene.ground])

    def page(points: Array) -> Array:
        return np.asarray((points - under) @ view[:2].T + [shift, 0.0])

    x, y = scene.height * np.array([[-1, 1, 1, -1], [-0.6, -0.6, 0.6, 0.6]])
    floor = page(under + np.column_stack([x, y, np.zeros(4)]))
    axes.fill(*floor.T, facecolor=FLOOR_COLOUR, edgecolor=GROUND_COLOUR, linewidth=0.6, zorder=1)
    forces = scene.forces[moment]
    depth = (scene.legs[moment] @ view[2]).mean(axis=1)
    for leg in np.argsort(depth):
        points, carries = page(scene.legs[moment, leg]), bool(np.any(forces[leg]))
        shade = colour if carries else SWING_COLOUR
        axes.plot(*points.T, color="#6b6b6b", linewidth=3.2, solid_capstyle="round", zorder=2)
        axes.plot(*points.T, color=shade, linewidth=2.2, solid_capstyle="round", zorder=2)
        axes.plot(*points[-1], marker="o", markersize=5, color=shade, markeredgecolor="#6b6b6b", zorder=3)
        if carries:
            foot = scene.legs[moment, leg, -1]
            tip = page(np.stack([foot, foot + forces[leg] * scene.height]))
            axes.annotate(
                "", tip[1], tip[0], arrowprops={"arrowstyle": "-|>", "color": FORCE_COLOUR, "linewidth": 1.2}, zorder=4
            )
    corners = page(scene.body[moment])
    for first, second in EDGES:
        axes.plot(*corners[[first, second]].T, color=BODY_COLOUR, linewidth=1.3, zorder=2.5)


def _draw_touching(axes: Axes, scene: WalkScene, start: float) -> None:
    """Dark lines along the bars where feet touched in the cycle from `start` s on."""
    first = round(start / scene.step)
    count = round(float(scene.durations.sum()) / scene.step)
    touching = scene.touching[first : first + count]
    for leg in range(len(scene.leg_names)):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], touching[:, leg], [False]]).astype(int)))
        for begin, end in edges.reshape(-1, 2) * scene.step:
            axes.plot([begin, end], [leg + BAR / 2 + 0.09] * 2, color=BODY_COLOUR, linewidth=2.0, solid_capstyle="butt")
