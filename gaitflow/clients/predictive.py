"""Predictive control of a single rigid body on the contacts of a motion: a user's own problem, solved by fatrop."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from gaitflow.clients.body_model import BODY_STATE, body_states, import_casadi, step_function
from gaitflow.clients.command import commanded
from gaitflow.core.layout import GRAVITY
from gaitflow.core.rigid_body import RigidBody
from gaitflow.core.trajectory import Array
from gaitflow.motion import Motion, State
from gaitflow.motion.arguments import checked_time

Start = Literal["motion", "cold"]
INTERVALS = 24  # of a horizon of one cycle
# Weights of squared errors from the command, SI units, per second; of forces over the weight.
PLACE, TURN, SPEED, SPIN, FORCE = (10.0, 10.0, 100.0), (50.0, 50.0, 50.0), (20.0, 20.0, 5.0), (1.0, 1.0, 1.0), 1.0
LAST = 0.1  # s, how long the last state counts
MOST_ITERATIONS = 100
TOLERANCE = 1e-5  # of forces over the weight among others; brings the cost within a per cent
BARRIER = 1e-4  # at the start, which is near


@dataclass(frozen=True, eq=False)
class Prediction:
    """A horizon of N intervals. times [N + 1] s; states [N + 1, 12], see `body_states`; forces [N, legs, 3] N.

    iterations of fatrop, the cost in the problem's own weights, whether it converged, and seconds of the call.
    """

    iterations: int
    cost: float
    ready: bool
    seconds: float
    times: Array
    states: Array
    forces: Array


class Predictor:
    """The problem of one robot, built once; contacts, footholds, command and state are its parameters.

    Over a cycle it tracks, weakly, what the task commands, with least forces in the friction pyramids of the feet that
    stand. Forces are constant in an interval. Not to be shared between threads.
    """

    def __init__(self, scenario: Mapping[str, Any], intervals: int = INTERVALS) -> None:
        """Raises ValueError for a robot in the plane and fewer than 2 intervals; ImportError without CasADi."""
        robot = scenario["robot"]
        if robot["dimension"] != 3:
            raise ValueError(f"robot {robot['name']}: is in the plane; the predicted body is in space")
        if isinstance(intervals, bool) or not isinstance(intervals, int) or intervals < 2:
            raise ValueError(f"intervals = {intervals!r}: must be a number, 2 or more")
        self._robot, self._intervals, self._legs = robot, intervals, len(robot["legs"])
        self._solver, self._lower, self._upper = self._built()

    def predict(
        self, motion: Motion, since: float = 0.0, state: Array | None = None, start: Start = "motion"
    ) -> Prediction:
        """The next cycle of a motion from time `since` [s] on, from a measured state [12], or else the motion's own.

        `start` is where the solver starts: at the motion's states and forces, or cold, in the first state all along
        with the weight shared by all legs. Raises ValueError for a motion of another robot and for bad numbers.
        """
        if motion.scenario["robot"] != self._robot:
            raise ValueError(f"motion of robot {motion.scenario['robot']['name']!r}, built for {self._robot['name']!r}")
        if start not in ("motion", "cold"):
            raise ValueError(f"start = {start!r}: must be 'motion' or 'cold'")
        began, motion = time.perf_counter(), motion.of_mass()
        times = checked_time(since, "since") + np.linspace(0.0, motion.period, self._intervals + 1)
        at, within = motion.sample(times), motion.sample((times[:-1] + times[1:]) / 2)
        states = body_states(at)
        first = states[0] if state is None else np.asarray(state, dtype=float)
        if first.shape != (BODY_STATE,) or not np.isfinite(first).all():
            raise ValueError(f"state: must be {BODY_STATE} finite numbers, found an array of shape {first.shape}")
        guess, forces = states, within.forces
        if start == "cold":
            guess = np.tile(first, (len(times), 1))
            forces = np.zeros_like(within.forces)
            forces[..., 2] = self._robot["mass"] * GRAVITY / self._legs
        solved = self._solver(
            x0=self._packed(guess, forces),
            p=self._parameters(motion, times, first, within),
            lbg=self._lower,
            ubg=self._upper,
        )
        found, pushes = self._unpacked(np.array(solved["x"]).ravel())
        stats = self._solver.stats()
        return Prediction(
            iterations=int(stats["iter_count"]),
            cost=float(solved["f"]),
            ready=bool(stats["success"]),
            seconds=time.perf_counter() - began,
            times=times,
            states=found,
            forces=pushes * within.contact[..., None],
        )

    def _built(self) -> tuple[Any, Array, Array]:
        """The solver, and the bounds of its rows.

        Variables are state and forces of each interval in turn, then the last state; rows of an interval are its step,
        in the first one the state that is given, then the forces' bounds. That order lets fatrop find the structure.
        """
        ca, n, legs = import_casadi(), self._intervals, self._legs
        step = step_function(np.array(self._robot["inertia"]), legs)
        weight, most = self._robot["mass"] * GRAVITY, self._robot["max_force"]
        given, gravity = ca.SX.sym("x0", BODY_STATE), ca.SX.sym("g", 3)
        mass, friction, h = ca.SX.sym("m"), ca.SX.sym("mu"), ca.SX.sym("h")
        contact, feet = ca.SX.sym("c", legs, n), ca.SX.sym("feet", 3 * legs, n)
        wanted = ca.SX.sym("ref", BODY_STATE, n + 1)
        states, forces = ca.SX.sym("x", BODY_STATE, n + 1), ca.SX.sym("u", 3 * legs, n)  # forces over the weight
        weights = ca.DM([*PLACE, *SPEED, *TURN, *SPIN])
        cost, variables, rows = 0, [], []
        lower: list[float] = []
        upper: list[float] = []
        for k in range(n):
            variables += [states[:, k], forces[:, k]]
            cost += h * (ca.dot(weights, (states[:, k] - wanted[:, k]) ** 2) + FORCE * ca.sumsqr(forces[:, k]))
            pushes = weight * forces[:, k] * ca.kron(contact[:, k], ca.DM.ones(3))
            rows.append(states[:, k + 1] - step(states[:, k], pushes, feet[:, k], gravity, mass, h))
            lower, upper = lower + [0.0] * BODY_STATE, upper + [0.0] * BODY_STATE
            if k == 0:
                rows.append(states[:, 0] - given)
                lower, upper = lower + [0.0] * BODY_STATE, upper + [0.0] * BODY_STATE
            for leg in range(legs):
                x, y, z = (forces[3 * leg + axis, k] for axis in range(3))
                rows += [z, friction * z - x, friction * z + x, friction * z - y, friction * z + y]
                lower, upper = lower + [0.0] * 5, upper + [most / weight] + [np.inf] * 4
        variables.append(states[:, n])
        cost += LAST * ca.dot(weights, (states[:, n] - wanted[:, n]) ** 2)
        parameters = ca.vertcat(given, gravity, mass, friction, h, ca.vec(contact), ca.vec(feet), ca.vec(wanted))
        problem = {"x": ca.vertcat(*variables), "f": cost, "g": ca.vertcat(*rows), "p": parameters}
        options = {
            "structure_detection": "auto",
            "equality": [low == high for low, high in zip(lower, upper, strict=True)],
            "expand": True,
            "print_time": False,
            "fatrop": {"print_level": 0, "max_iter": MOST_ITERATIONS, "tolerance": TOLERANCE, "mu_init": BARRIER},
        }
        return ca.nlpsol("predictor", "fatrop", problem, options), np.array(lower), np.array(upper)

    def _parameters(self, motion: Motion, times: Array, first: Array, within: State) -> Array:
        body, wanted = RigidBody.of(self._robot, motion.task), commanded(motion, times)
        n = len(times)
        upright = np.column_stack([wanted.heading, np.zeros((n, 2))])
        turning = np.column_stack([np.zeros((n, 2)), np.full(n, wanted.yaw_rate)])
        reference = np.hstack([wanted.position, wanted.velocity, upright, turning])
        scalars = [body.mass, motion.task["friction"], times[1] - times[0]]
        parts = [first, body.gravity, np.array(scalars), within.contact.astype(float), within.feet, reference]
        return np.concatenate([part.ravel() for part in parts])

    def _packed(self, states: Array, forces: Array) -> Array:
        controls = forces.reshape(len(forces), -1) / (self._robot["mass"] * GRAVITY)
        return np.concatenate([np.hstack([states[:-1], controls]).ravel(), states[-1]])

    def _unpacked(self, variables: Array) -> tuple[Array, Array]:
        n, last = self._intervals, len(variables) - BODY_STATE
        rows = variables[:last].reshape(n, -1)
        forces = rows[:, BODY_STATE:].reshape(n, self._legs, 3) * self._robot["mass"] * GRAVITY
        return np.vstack([rows[:, :BODY_STATE], variables[last:]]), forces
