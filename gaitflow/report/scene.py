"""A stored motion as things to draw in space: body, hips, feet and forces at any time; a planar robot has y = 0."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.layout import GRAVITY
from gaitflow.core.rigid_body import Attitude
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.core.twist import displacements, headings
from gaitflow.report.winners import trajectory_of
from gaitflow.search.solution import Solution

BODY_HEIGHT = 0.2  # thickness of the drawn body, as a share of its height above the ground


@dataclass(frozen=True)
class Pose:
    """The robot at one moment; metres and newtons, world frame: x forward, y to the left, z up from the ground."""

    position: Array  # [3] base
    rotation: Array  # [3, 3] base to world
    hips: Array  # [legs, 3]
    feet: Array  # [legs, 3]
    forces: Array  # [legs, 3]
    standing: tuple[bool, ...]  # [legs] by the pattern


@dataclass(frozen=True)
class Scene:
    """The whole motion in space, at its knots and between them.

    Feet move and forces change linearly within a step. `curved`: position and angles follow the cubics through their
    values and rates at both knots, which for linear forces is the centre of mass' true path; otherwise, for forward
    Euler, they follow the straight lines that it took.
    """

    times: Array  # [K+1] s, from 0
    position: Array  # [K+1, 3] m
    velocity: Array  # [K+1, 3] m/s
    angles: Array  # [K+1, 3] rad: yaw, pitch, roll; R_base->world = Rz(yaw) Ry(pitch) Rx(roll)
    angle_rates: Array  # [K+1, 3] rad/s
    feet: Array  # [K+1, legs, 3] m
    forces: Array  # [K, legs, 3] N at the start of each step
    end_forces: Array  # [K, legs, 3] N at its end
    durations: Array  # [phases] s
    rows: tuple[str, ...]  # [legs] the pattern's rows
    default_feet: Array  # [legs, 3] m, base frame
    box: Array  # [3] m, half lengths of the kinematic box
    weight: float  # N
    task: Task
    planar: bool
    curved: bool

    @property
    def slope(self) -> float:
        """Inclination of the ground [rad]."""
        return float(np.deg2rad(self.task["slope"]))

    @property
    def hips(self) -> Array:
        """[legs, 3] m, base frame: above the default feet, at the height of the base."""
        return np.asarray(self.default_feet * [1.0, 1.0, 0.0])

    @property
    def height(self) -> float:
        """How far the default feet lie below the base [m]."""
        return -float(self.default_feet[:, 2].mean())

    @property
    def body(self) -> Array:
        """[8, 3] m, base frame: corners of the drawn body, which spans the hips; corner i has the bits x, y, z of i."""
        low, high = self.hips.min(axis=0), self.hips.max(axis=0)
        thickness = BODY_HEIGHT * self.height
        low[2], high[2] = -thickness / 2, thickness / 2
        corners = [[(low, high)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)]
        return np.array(corners)

    @property
    def path(self) -> Array:
        """Where the commanded twist has brought its frame at each knot: x, y [K+1, 2] m."""
        return displacements(self.task, self.times)

    @property
    def headings(self) -> Array:
        """Where that frame faces at each knot [K+1] rad."""
        return headings(self.task, self.times)

    def at(self, time: float) -> Pose:
        """The pose `time` seconds into the cycle."""
        step = int(np.clip(np.searchsorted(self.times, time, side="right") - 1, 0, len(self.times) - 2))
        h = max(float(self.times[step + 1] - self.times[step]), 1e-12)
        part = (time - self.times[step]) / h

        def line(first: Array, last: Array) -> Array:
            return np.asarray((1 - part) * first + part * last)

        def path(values: Array, rates: Array) -> Array:
            straight = line(values[step], values[step + 1])
            if not self.curved:
                return straight
            mean = (values[step + 1] - values[step]) / h
            bend = (1 - part) * (rates[step] - mean) - part * (rates[step + 1] - mean)
            return np.asarray(straight + h * part * (1 - part) * bend)

        position, rotation = path(self.position, self.velocity), rotation_of(path(self.angles, self.angle_rates))
        phase = int(np.searchsorted(np.cumsum(self.durations)[:-1], time, side="right"))
        return Pose(
            position=position,
            rotation=rotation,
            hips=position + self.hips @ rotation.T,
            feet=line(self.feet[step], self.feet[step + 1]),
            forces=line(self.forces[step], self.end_forces[step]),
            standing=tuple(row[phase] == "1" for row in self.rows),
        )


def scene_of(solution: Solution, scenario: Scenario) -> Scene:
    """The scene of a solution. Raises ValueError when no trajectory was stored, or one with a NaN or an infinity."""
    trajectory, robot = trajectory_of(solution), scenario.robot
    broken = [one.name for one in fields(trajectory) if not np.isfinite(getattr(trajectory, one.name)).all()]
    if broken:
        raise ValueError(
            f"the motion at {solution.task.text()} has numbers that are not finite in "
            f"{', '.join(broken)}; run `gaitflow verify` on its dataset"
        )
    planar, d = robot.dimension == 2, robot.dimension
    position, angles, velocity, omega = np.split(trajectory.base, np.cumsum([d, len(robot.inertia), d]), axis=1)
    rates = Attitude(angles).rates(omega)
    if planar:  # nose up is positive in the plane; about the lateral axis in space it is negative
        angles, rates = (values * [0.0, -1.0, 0.0] for values in (angles, rates))
    return Scene(
        times=trajectory.times - trajectory.times[0],
        position=_in_space(position),
        velocity=_in_space(velocity),
        angles=angles,
        angle_rates=rates,
        feet=_in_space(trajectory.feet),
        forces=_in_space(trajectory.forces),
        end_forces=_in_space(trajectory.end_forces),
        durations=trajectory.durations,
        rows=tuple(solution.pattern.split("/")),
        default_feet=_in_space(np.array([leg.default_foot for leg in robot.legs])),
        box=_in_space(np.array(robot.box)),
        weight=robot.mass * GRAVITY,
        task=solution.task,
        planar=planar,
        curved=scenario.transcription.integrator != "euler",
    )


def _in_space(vectors: Array) -> Array:
    """[..., 3] of [..., 2 or 3]: a vector (x, z) of the plane has y = 0."""
    return vectors if vectors.shape[-1] == 3 else np.insert(vectors, 1, 0.0, axis=-1)


def rotation_of(angles: Array) -> Array:
    """Base to world [3, 3] for (yaw, pitch, roll) [rad]."""
    (cy, cp, cr), (sy, sp, sr) = np.cos(angles), np.sin(angles)
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    return np.asarray(about_z @ about_y @ about_x)


def camera(azimuth: float, elevation: float) -> Array:
    """[3, 3] world to view for angles in rad: x to the right of the page, y up the page, z out of it.

    From the robot's right side at azimuth and elevation 0, where the view's x and y are the world's x and z; azimuth
    turns the camera towards the front, elevation raises it. The projection is parallel.
    """
    (ca, ce), (sa, se) = np.cos([azimuth, elevation]), np.sin([azimuth, elevation])
    return np.array([[ca, sa, 0], [-sa * se, ca * se, ce], [sa * ce, -ca * ce, se]])
