"""A stored motion as a moving picture (GIF) that repeats without a seam: one cycle, slowed down."""

from __future__ import annotations

import io

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from gaitflow.config.scenario import Scenario
from gaitflow.core.trajectory import Array
from gaitflow.core.twist import displacements, headings
from gaitflow.report import axis_text
from gaitflow.report.gait_diagrams import draw_contacts
from gaitflow.report.scene import Scene, scene_of
from gaitflow.report.snapshot import BODY_COLOUR, Snapshot, snapshot, view_of
from gaitflow.search.solution import Solution

FRAMES_PER_SECOND = 25
SLOWER = 2  # than in life
WIDTH, DOTS = 4.6, 100  # inches, dots per inch
COLOURS = 64  # of the whole picture, one palette for all frames: half the size of a palette a frame
MARK_COLOUR = "#d8d8d4"  # of the lines on the ground


def film(solution: Solution, scenario: Scenario, gait: str, colour: str) -> bytes:
    """The motion as an animated GIF, seen by a camera that follows the commanded twist at its steady pace.

    Lines lie still across the commanded path; legs, forces and ground are drawn as `gaitflow.report.snapshot` says.
    Raises ValueError when the solution has no trajectory.
    """
    scene = scene_of(solution, scenario)
    cycle = float(scene.times[-1])
    times = np.arange(max(round(cycle * SLOWER * FRAMES_PER_SECOND), 2)) / (SLOWER * FRAMES_PER_SECOND)
    times *= cycle / (times[-1] + times[1])  # the last frame is one step before the first one of the next cycle
    shots = [_shot(scene, float(time)) for time in times]
    points = np.concatenate([shot.points for shot in shots])
    (left, low), (right, high) = points.min(axis=0), points.max(axis=0)
    margin = 0.08 * scene.height
    bars_height = 0.17 * len(scene.rows)
    height = (high - low + 2 * margin) / (right - left + 2 * margin) * WIDTH
    figure = Figure(figsize=(WIDTH, height + bars_height + 0.85), dpi=DOTS, layout="constrained")
    figure.suptitle(gait, fontsize=10, x=0.02, horizontalalignment="left")
    stage, bars = figure.subplots(2, 1, height_ratios=[height, bars_height])
    draw_contacts(bars, solution.pattern, scene.durations, scenario.robot.leg_names, colour)
    bars.set_xlabel("time [s]", fontsize=9)
    cursor = bars.axvline(0.0, color=BODY_COLOUR, linewidth=1.2)
    task = f"{axis_text.values(solution.task, scenario.tasks.space.columns)}, {SLOWER} times slower"

    def draw(time: float, shot: Snapshot) -> None:
        stage.clear()
        _draw_marks(stage, scene, time)
        shot.draw(stage, colour)
        stage.set_xlim(left - margin, right + margin)
        stage.set_ylim(low - margin, high + margin)
        stage.set_aspect("equal", anchor="S")
        stage.set_axis_off()
        stage.set_title(task, fontsize=8, loc="left", color="#555555")
        cursor.set_xdata([time, time])

    canvas, frames = FigureCanvasAgg(figure), []
    for time, shot in zip(times, shots, strict=True):
        draw(float(time), shot)
        canvas.draw()
        frames.append(np.array(canvas.buffer_rgba())[..., :3])
    return _gif(frames)


def _gif(frames: list[NDArray[np.uint8]]) -> bytes:
    """Frames [height, width, 3] as a GIF that starts again without an end."""
    palette = Image.fromarray(np.concatenate(frames)).quantize(COLOURS, Image.Quantize.FASTOCTREE)
    # Dithering would make every frame differ from the one before all over, and only what differs is stored.
    first, *others = [Image.fromarray(each).quantize(palette=palette, dither=Image.Dither.NONE) for each in frames]
    file, duration = io.BytesIO(), 1000 // FRAMES_PER_SECOND
    first.save(file, "GIF", save_all=True, append_images=others, duration=duration, loop=0)
    return file.getvalue()


def _shot(scene: Scene, time: float) -> Snapshot:
    heading = float(headings(scene.task, np.array(time)))
    half_width = 0.75 * float(np.ptp(scene.hips[:, 0])) + 0.5 * scene.height
    return snapshot(scene, scene.at(time), view_of(scene, heading), _below(scene, time), 0.0, half_width)


def _below(scene: Scene, time: float) -> Array:
    """The point of the ground [3] that the camera looks at: where the twist has brought the first one."""
    return np.append(scene.position[0, :2] - scene.path[0] + displacements(scene.task, np.array(time)), 0.0)


def _draw_marks(axes: Axes, scene: Scene, time: float) -> None:
    """Lines across the commanded path, which the robot leaves behind; a cycle passes a whole number of them."""
    cycle, length = float(scene.times[-1]), float(np.abs(np.diff(scene.path, axis=0)).sum())
    count = max(round(length / (0.6 * scene.height)), 1)
    view = view_of(scene, float(headings(scene.task, np.array(time))))
    x, y = 0.5 * np.ptp(scene.hips, axis=0)[:2] + 0.25 * scene.height
    for number in range(-3 * count, 4 * count + 1):
        passed = number / count * cycle
        heading = float(headings(scene.task, np.array(passed)))
        across = np.array([-np.sin(heading), np.cos(heading), 0.0])
        ends = (_below(scene, passed) - _below(scene, time)) + np.outer([-1.0, 1.0], across * y)
        nearer = abs(passed - time) / cycle * length < x
        if scene.planar:
            ends = ends[0] + np.array([[0.0, 0.0, 0.0], [-0.06, 0.0, -0.09]]) * scene.height
        if nearer or scene.planar:
            axes.plot(*(ends @ view[:2].T).T, color=MARK_COLOUR, linewidth=1.4, zorder=1.5)
