"""A scenario S = [task, environment, objective] of the paper (section III.A), and how to solve and learn it.

A scenario file is data: it names a robot, an objective, a transcription, the axes of its tasks (the terrain's slope and
friction among them), a search strategy and learning settings. `load_scenario` resolves the robot's name to its
parameters, so that a `Scenario` is complete: its JSON is all that a worker, a dataset or a map needs to know.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from reprlib import repr as short
from typing import Annotated, Any, Literal

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from gaitflow import shipped
from gaitflow.config.axes import Range, Tasks
from gaitflow.config.file import Config, ConfigError, meant, read_yaml, require_mapping
from gaitflow.config.limits import Limits
from gaitflow.config.robot import Robot, load_robot
from gaitflow.core.gaits import Symmetry
from gaitflow.core.task import AXES, Task

__all__ = [
    "Learning", "Objective", "Range", "Scenario", "Strategy", "Tasks", "Transcription", "digest_of", "load_scenario"
]  # fmt: skip

Classifier = Literal["mlp", "svm", "forest", "knn"]
CLASSIFIERS: tuple[Classifier, ...] = ("mlp", "svm", "forest", "knn")
Weight = Annotated[float, Field(ge=0)]
Count = Annotated[int, Field(ge=1)]
Widths = Annotated[tuple[Count, ...], Field(min_length=1)]
Rate = Annotated[float, Field(gt=0)]


class Objective(Config):
    """Weights of the integrands of eq. (8)-(10); a term with weight 0 is left out.

    Velocity, tilt and lateral feet are taken in the frame that follows the commanded twist. J1 is `force: 1`; J2 is 1e6
    on the two velocities, tilt and tilt rate; J3 adds force and lateral foot. J4 is energy: what joints' torques turn
    into heat, and the work that joints do.
    """

    force: Weight = 0.0  # sum of squared contact forces [N^2 s]
    tangential_velocity: Weight = 0.0  # (v_t - v)^2, in 3D with the lateral velocity [m^2/s]
    normal_velocity: Weight = 0.0  # v_n^2 [m^2/s]
    tilt: Weight = 0.0  # base angles against the terrain, squared [rad^2 s]
    tilt_rate: Weight = 0.0  # their rates, squared [rad^2/s]
    lateral_foot: Weight = 0.0  # (P_y - default P_y)^2, 3D only [m^2 s]
    force_rate: Weight = 0.0  # squared rates of contact forces, jumps between phases as ramps of 20 ms [N^2/s]
    joint_heat: Weight = 0.0  # sum of squared joint torques, 3D only [N^2 m^2 s]; a weight in W / (N m)^2 makes it J
    joint_work: Weight = 0.0  # sum of the joints' positive power, 3D only [J]
    swing_reaction: Weight = 0.0  # squared torque of all swinging legs' hips on the base, of energy only [N^2 m^2 s]

    @model_validator(mode="after")
    def _not_empty(self) -> Objective:
        if not any(self.model_dump().values()):
            raise ValueError("at least one weight must be positive")
        return self

    @property
    def energy(self) -> bool:
        """Whether joints count, which a robot's limbs decide."""
        return bool(self.joint_heat or self.joint_work)

    @model_serializer(mode="wrap")
    def _without_unused(self, data: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Objectives without energy, force rate or swing reaction are the same data as before there was any."""
        found: dict[str, Any] = data(self)
        unused = set() if self.energy else {"joint_heat", "joint_work"}
        unused |= {name for name in ("force_rate", "swing_reaction") if not found[name]}
        return {key: value for key, value in found.items() if key not in unused}


class Transcription(Config):
    """Section III.B: phases, knots in each, how a step is integrated, and the shortest phase.

    The paper's is `euler` with held forces and even knots. `momentum` is exact in the linear and angular momentum.
    """

    phases: Annotated[int, Field(ge=2, le=12)] = 4
    knots_per_phase: Annotated[int, Field(ge=2, le=50)] = 10
    integrator: Literal["euler", "rk4", "midpoint", "hermite_simpson", "momentum"] = "euler"
    forces: Literal["held", "linear"] = "held"  # over one step
    grading: Annotated[float, Field(ge=0, le=1)] = 0.0  # 0: even knots, 1: spaced by a cosine within each phase
    min_phase_fraction: Annotated[float, Field(gt=0, lt=1)] = 0.1

    @model_validator(mode="after")
    def _phases_fit(self) -> Transcription:
        if self.phases * self.min_phase_fraction > 1:
            raise ValueError(
                f"min_phase_fraction = {self.min_phase_fraction:g}: phases = {self.phases} of at least this part of "
                f"the cycle do not fit into it; allowed is at most 1/{self.phases}"
            )
        return self

    @property
    def time_symmetric(self) -> bool:
        """Whether a motion run backwards is a motion, too: so for rules that treat both ends of a step alike."""
        return self.integrator in ("midpoint", "hermite_simpson", "momentum")


class Strategy(Config):
    """How the best gait of a task is searched: see `gaitflow.search`."""

    name: Literal["patterns", "guided", "bonmin", "fixed_gait"] = "patterns"
    restarts: Count = 3  # random starts: per task (bonmin), per pattern that fails (all others)
    seed: Annotated[int, Field(ge=0)] = 0
    pattern: str | None = None  # fixed_gait only: legs' rows joined by "/", such as "0110/1100"
    budget: Count = 300  # guided only: patterns probed at a task
    part: tuple[int, int] | None = None  # patterns only: [i, n] searches the i-th of n parts, from 0
    incumbent: Annotated[float, Field(gt=0)] | None = None  # patterns only: leave out what is sure to cost more
    solve_time_limit: Annotated[float, Field(gt=0)] = 20.0  # CPU seconds of one solver call
    tasks_per_unit: Annotated[int, Field(ge=1, le=1000)] = 6  # neighbouring speeds solved as one unit of work

    @model_validator(mode="after")
    def _pattern_fits(self) -> Strategy:
        if (self.pattern is not None) != (self.name == "fixed_gait"):
            pattern = "null" if self.pattern is None else short(self.pattern)
            raise ValueError(
                f"name = {self.name!r}, pattern = {pattern}: a pattern is needed by the strategy 'fixed_gait', "
                "and allowed for no other"
            )
        return self

    @model_validator(mode="after")
    def _part_fits(self) -> Strategy:
        if (self.part, self.incumbent) != (None, None) and self.name != "patterns":
            raise ValueError(
                f"name = {self.name!r}, part = {self.part}, incumbent = {self.incumbent}: only the strategy 'patterns' "
                "is cut into parts or knows an incumbent; leave both out"
            )
        if self.part is not None and not 0 <= self.part[0] < self.part[1]:
            raise ValueError(f"part = {list(self.part)}: write [i, n] with 0 <= i < n")
        return self


class Learning(Config):
    """Classifiers and their cross-validation (section III.C).

    `methods` are those that compete: the paper's perceptron, support vectors, a random forest, nearest neighbours.
    """

    methods: Annotated[tuple[Classifier, ...], Field(min_length=1)] = CLASSIFIERS
    folds: Annotated[int, Field(ge=2, le=20)] = 5
    seed: Annotated[int, Field(ge=0)] = 0
    tie_tolerance: Annotated[float, Field(ge=0, lt=0.1)] = 1e-3  # relative cost within which gaits tie
    hidden_layers: Annotated[tuple[Widths, ...], Field(min_length=1)] = ((100, 80, 50), (80, 80, 70), (120, 70, 40))
    learning_rates: Annotated[tuple[Rate, ...], Field(min_length=1)] = (1e-3, 1e-2)
    weight_decays: Annotated[tuple[Weight, ...], Field(min_length=1)] = (1e-4, 1e-2)
    max_epochs: Count = 300

    @model_serializer(mode="wrap")
    def _without_all_methods(self, data: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Scenarios for which all methods compete are the same data as before there was a choice."""
        found: dict[str, Any] = data(self)
        return {key: found[key] for key in found if key != "methods" or self.methods != CLASSIFIERS}


class Scenario(Config):
    """Everything that defines a gait map. Frozen; equal scenarios have equal digests."""

    name: Annotated[str, Field(pattern=r"^[a-z0-9]+(-[a-z0-9]+)*$", max_length=80)]
    description: str = ""
    robot: Robot
    objective: Objective
    transcription: Transcription = Transcription()
    stances_per_leg: Literal[1, None] = None  # 1: every leg touches down exactly once a cycle; null: any number
    swing_clearance: Annotated[float, Field(ge=0, lt=1)] = 0.0  # of a foot over the ground in the middle of a swing [m]
    tasks: Tasks
    strategy: Strategy = Strategy()
    learning: Learning = Learning()
    limits: Limits = Limits()

    @model_validator(mode="after")
    def _terms_agree(self) -> Scenario:
        if self.objective.lateral_foot and self.robot.dimension == 2:
            raise ValueError(
                f"objective.lateral_foot = {self.objective.lateral_foot:g}: needs a robot with dimension 3, "
                f"{self.robot.name} has 2; allowed is 0"
            )
        if self.swing_clearance > 2 * self.robot.box[-1]:
            raise ValueError(
                f"swing_clearance = {self.swing_clearance:g}: the kinematic box lets a foot be "
                f"{2 * self.robot.box[-1]:g} m above another; allowed is at most that"
            )
        if self.swing_clearance and self.strategy.name == "bonmin":
            raise ValueError(
                f"swing_clearance = {self.swing_clearance:g}: the strategy 'bonmin' knows no middle of a swing; "
                "allowed is 0"
            )
        if self.tasks.adaptive is not None and self.strategy.name not in ("patterns", "guided"):
            raise ValueError(
                f"tasks.sampling: needs a search for the best gait, strategy.name = {self.strategy.name!r} is none; "
                "choose patterns or guided, or a grid"
            )
        if self.objective.force_rate and self.transcription.forces != "linear":
            raise ValueError(
                f"objective.force_rate = {self.objective.force_rate:g}: held forces have no rate; it needs "
                "transcription.forces = linear"
            )
        if self.objective.swing_reaction and not self.objective.energy:
            raise ValueError(
                f"objective.swing_reaction = {self.objective.swing_reaction:g}: goes with energy; give "
                "joint_heat or joint_work as well, or leave it out"
            )
        if self.objective.energy:
            self._has_joints()
        spatial = [axis for axis in AXES if AXES[axis].spatial and self.tasks.varies(axis)]
        if spatial and self.robot.dimension == 2:
            raise ValueError(
                f"tasks.axes.{spatial[0]}: needs a robot with dimension 3, {self.robot.name} has 2; leave it out"
            )
        if self.tasks.varies("yaw_rate") and self.tasks.varies("slope"):
            raise ValueError(
                "tasks.axes: yaw_rate and slope: turning on a slope is not periodic, as gravity turns against the "
                "body; leave one of them out"
            )
        pattern = self.strategy.pattern
        if pattern is not None:
            rows = pattern.split("/")
            legs, phases = self.robot.leg_names, self.transcription.phases
            if len(rows) != len(legs) or any(len(row) != phases or row.strip("01") for row in rows):
                raise ValueError(
                    f"strategy.pattern = {short(pattern)}: write {len(legs)} rows (legs {', '.join(legs)}) of {phases} "
                    "digits 0 (swing) or 1 (stance), joined by '/'"
                )
        return self

    @model_serializer(mode="wrap")
    def _without_unused(self, data: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Scenarios without clearance, or with the usual limits, are the same data as before there were any."""
        found: dict[str, Any] = data(self)
        unused = set() if self.swing_clearance else {"swing_clearance"}
        unused |= {"limits"} if self.limits == Limits() else set()
        return {key: found[key] for key in found if key not in unused}

    def _has_joints(self) -> None:
        """Energy needs joints, a cost that is no sum over Euler's steps, and feet as fast a cycle later."""
        weights = f"objective.joint_work = {self.objective.joint_work:g}, joint_heat = {self.objective.joint_heat:g}"
        if self.robot.dimension == 2:
            raise ValueError(f"{weights}: need a robot with dimension 3, {self.robot.name} has 2; allowed is 0")
        if self.robot.limbs is None:
            raise ValueError(
                f"{weights}: the robot {self.robot.name} says nothing of its joints (limbs): `gaitflow robot import` "
                "it again"
            )
        if self.transcription.integrator == "euler":
            raise ValueError(f"{weights}: need another transcription.integrator than euler, such as momentum")
        if self.stances_per_leg is None:
            raise ValueError(f"{weights}: need stances_per_leg = 1, as a leg's swing is one")
        if self.strategy.name == "bonmin":
            raise ValueError(f"{weights}: the strategy 'bonmin' knows no swing's duration; choose another one")
        if self.tasks.varies("acceleration"):
            raise ValueError("tasks.axes.acceleration: its energy is not modelled; leave the axis or the energy out")

    @property
    def follows_swings(self) -> bool:
        """Whether swings are curves of a height of their own, which legs pay for and have to reach."""
        return self.objective.energy and self.swing_clearance > 0

    @property
    def problem_digest(self) -> str:
        """Digest of what a single solve depends on beside its task: robot, objective, transcription, stances."""
        return digest_of(self.problem_data)

    @property
    def problem_data(self) -> dict[str, Any]:
        """The part of `as_data` that a single solve depends on, beside its task.

        Of the axes only those that vary: their terms are in the problem.
        """
        data = self.as_data()
        parts = ("robot", "objective", "transcription", "stances_per_leg", "swing_clearance")
        kept = {key: data[key] for key in parts if key in data}
        beside = {"source", "frames"}  # prose and names, no physics
        beside |= set() if self.objective.energy else {"limbs"}
        kept["robot"] = {key: value for key, value in data["robot"].items() if key not in beside}
        return kept | {"axes": [axis for axis in AXES if self.tasks.varies(axis)]}

    def symmetry(self, task: Task) -> Symmetry:
        """Which patterns are one gait at a task: the images under which robot, ground and task stay as they are.

        While the body speeds up, a cycle is another motion from wherever it begins.
        """
        robot = self.robot
        mirror = robot.mirror_permutation if robot.mirror and task.mirrored() == task else None
        reversible = self.transcription.time_symmetric and task.time_reversed() == task
        # Of energy both directions take about the same, where knees are alike, too, but not to the last digits.
        reversible = reversible and not self.objective.energy
        reversal = robot.reversal_permutation if reversible else None
        return Symmetry(mirror, reversal, rotation=task["acceleration"] == 0)


def digest_of(data: Any) -> str:
    """SHA-256 of canonical JSON: sorted keys, no spaces, shortest float text."""
    text = json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def load_scenario(path: Path, robots: Path | None = None) -> Scenario:
    """Read a scenario YAML and the robot it names.

    A robot that ends in .yaml is a file, its path relative to the scenario's folder. Any other is looked for in the
    folder `robots`, in `../robots` beside the scenario's folder, and among the robots that ship.
    Raises ConfigError that names the file, the field, the value and what is allowed.
    """
    data = dict(require_mapping(read_yaml(path), str(path)))
    if "robot" not in data:
        return Scenario.from_data(data, str(path))  # raises: every scenario names a robot
    data["robot"] = load_robot(_robot_file(path, data["robot"], robots)).as_data()
    return Scenario.from_data(data, str(path))


def _robot_file(scenario: Path, name: Any, robots: Path | None) -> Path:
    if isinstance(name, str) and name.endswith((".yaml", ".yml")):
        return scenario.parent / name
    folders = ([] if robots is None else [robots]) + [scenario.resolve().parent.parent / "robots", shipped.ROBOTS]
    known = {file.stem: file for folder in reversed(folders) for file in folder.glob("*.yaml")}
    if isinstance(name, str) and name in known:
        return known[name]
    raise ConfigError(
        f"{scenario}: robot = {short(name)}: unknown robot{meant(name, known)} allowed: {', '.join(sorted(known))}"
    )
