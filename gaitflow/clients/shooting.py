"""Whole-body motion by shooting: Crocoddyl's solver on a motion's contact sequence, started from the motion or cold."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gaitflow.clients.shooting_problem import import_crocoddyl, shooting_problem
from gaitflow.clients.whole_body import WholeBody
from gaitflow.core.trajectory import Array
from gaitflow.motion import Motion
from gaitflow.motion.arguments import checked_count

Start = Literal["motion", "cold"]
STEP = 0.02  # s
MOST_ITERATIONS = 100
STOP = 1e-5  # expected improvement of the cost, which is some units


@dataclass(frozen=True, eq=False)
class Shot:
    """What Crocoddyl made of a problem.

    iterations it took and the cost in the problem's own weights; ready: whether it converged to a motion without gaps.
    seconds of the solve alone. times [N + 1] s, configurations [N + 1, nq] and torques [N, joints] N m as in a
    `JointMotion`. feet_error [m]: the farthest that a standing foot is from the motion's foothold.
    """

    iterations: int
    cost: float
    ready: bool
    seconds: float
    feet_error: float
    times: Array
    configurations: Array
    torques: Array

    @property
    def base_path(self) -> Array:
        """Positions of the base link's origin [N + 1, 3] m."""
        return self.configurations[:, :3]


def shoot(body: WholeBody, motion: Motion, cycles: int = 2, dt: float = STEP, start: Start = "motion") -> Shot:
    """Solve the shooting problem of a motion's first cycles by feasibility-driven DDP.

    The problem takes contacts, swinging feet and the first state from the motion. What it tracks weakly is what the
    task commands: the twist, at the height and in the pose of standing; so costs of two gaits at one task compare.
    `start` is where the solver starts: at the motion's joint angles, velocities and torques, or cold, in the first
    state all along with torques that hold it still. dt [s] is rounded so that it divides the cycles.

    Raises ValueError for a motion of another robot, on a slope or with a payload, and for numbers that cannot be;
    ImportError without Crocoddyl.
    """
    if not 0 < dt <= motion.period:
        raise ValueError(f"dt = {dt!r}: must be above 0 s, and at most the cycle's {motion.period:g} s")
    if start not in ("motion", "cold"):
        raise ValueError(f"start = {start!r}: must be 'motion' or 'cold'")
    crocoddyl, duration = import_crocoddyl(), checked_count(cycles) * motion.period
    path = body.along(motion, np.linspace(0.0, duration, round(duration / dt) + 1))
    problem = shooting_problem(body, motion, path)
    states = list(np.hstack([path.configurations, path.velocities]))
    torques = list(path.torques)
    if start == "cold":
        states = [states[0]] * len(states)
        torques = list(problem.quasiStatic(states[:-1]))
    solver = crocoddyl.SolverFDDP(problem)
    solver.th_stop = STOP
    began = time.perf_counter()
    converged = solver.solve(states, torques, MOST_ITERATIONS)
    seconds = time.perf_counter() - began
    configurations = np.array(list(solver.xs))[:, : body.mechanism.model.nq]
    return Shot(
        iterations=int(solver.iter),
        cost=float(solver.cost),
        ready=bool(converged and solver.isFeasible),
        seconds=seconds,
        feet_error=_feet_error(body, motion, path.times, configurations),
        times=path.times,
        configurations=configurations,
        torques=np.array(list(solver.us)),
    )


def _feet_error(body: WholeBody, motion: Motion, times: Array, configurations: Array) -> float:
    """The farthest [m] that a foot is from its foothold at both ends of the intervals in which it stands."""
    within = motion.sample((times[:-1] + times[1:]) / 2)
    feet = np.array([body.feet_at(q) for q in configurations])
    off = [np.linalg.norm(feet[ends] - within.feet, axis=-1)[within.contact] for ends in (np.s_[:-1], np.s_[1:])]
    return float(np.concatenate(off).max(initial=0.0))
