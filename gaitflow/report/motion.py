"""Snapshots of one motion over its cycle with contact forces, in the manner of Fig. 2 and 9."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from gaitflow.config.scenario import Scenario
from gaitflow.report import axis_text
from gaitflow.report.gait_diagrams import draw_contacts
from gaitflow.report.scene import scene_of
from gaitflow.report.snapshot import BODY_COLOUR, snapshot, view_of
from gaitflow.search.solution import Solution

SNAPSHOTS = 6
WIDTH = 8.4  # inches


def draw_motion(solution: Solution, scenario: Scenario, gait: str, colour: str) -> Figure:
    """A strip of snapshots, evenly spaced over the cycle, above the contact bars of the same time.

    Each is drawn as `gaitflow.report.snapshot` says. Raises ValueError when the solution has no trajectory.
    """
    scene = scene_of(solution, scenario)
    body = scene.body @ view_of(scene).T
    spacing = 1.45 * max(float(np.ptp(body[:, 0])), 2 * scene.height)
    lean = 0.5 * scene.height * np.sin(scene.slope)  # up a slope the body stands behind the ground below it
    times = (np.arange(SNAPSHOTS) + 0.5) / SNAPSHOTS * scene.times[-1]
    turns = np.interp(times, scene.times, scene.headings)  # the camera turns with the command
    shots = []
    for place, (time, turn) in enumerate(zip(times, turns, strict=True)):
        pose = scene.at(time)
        below = pose.position * [1.0, 1.0, 0.0]
        along = spacing * (place + 0.5) + lean
        shots.append(snapshot(scene, pose, view_of(scene, turn), below, along, 0.46 * spacing))
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
