"""What a robot's limbs may be, what is said of those that it cannot have, and who needs them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitflow.config.file import ConfigError
from gaitflow.config.robot import Robot, load_robot
from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.core.task import Task

CONFIGS = Path(__file__).parents[2] / "configs"
Data = dict[str, Any]
Edit = Callable[[Data], Any]


@pytest.fixture
def robot() -> Data:
    """ANYmal's data."""
    return load_robot(CONFIGS / "robots" / "anymal.yaml").as_data()


@pytest.fixture
def energy() -> Data:
    """Data of ANYmal's scenario of energy, with a grid of tasks, which any strategy may search."""
    data = load_scenario(CONFIGS / "scenarios" / "anymal-energy.yaml").as_data()
    del data["tasks"]["sampling"]
    return data


def refusal(of: type[Robot] | type[Scenario], data: Data) -> str:
    with pytest.raises(ConfigError) as caught:
        of.from_data(data, "here")
    assert "\n" not in str(caught.value), "one line says it"
    return str(caught.value).removeprefix("here: ")


def set_limb(index: int, **values: Any) -> Edit:
    def edit(robot: Data) -> None:
        limbs = [dict(limb) for limb in robot["limbs"]]
        limbs[index] |= values
        robot["limbs"] = limbs

    return edit


def swapped(robot: Data) -> None:
    robot["limbs"] = [robot["limbs"][index] for index in (1, 0, 2, 3)]


@pytest.mark.parametrize(
    ("edit", "said"),
    [
        (
            set_limb(0, thigh=0.1),
            "limbs: LF's default foot is 0.469 m from its hip; a thigh of 0.1 m and a shank of 0.",
        ),
        (set_limb(1, shank=0.8), "limbs: RF's default foot is 0.469 m from its hip; a thigh of 0.25 m and a shank of "),
        (set_limb(2, aside=0.9), "limbs: LH's default foot is "),
        (
            set_limb(1, aside=-0.12),
            "limbs: RF's must be the mirror image of LF's when mirror = (('LF', 'RF'), ('LH', '",
        ),
        (set_limb(3, knee="backward"), "limbs: RH's must be the mirror image of LH's when mirror = "),
        (set_limb(0, knee="inward"), "limbs.0.knee = 'inward': Input should be 'forward' or 'backward'"),
        (set_limb(0, thigh=0.0), "limbs.0.thigh = 0.0: Input should be greater than 0"),
        (set_limb(0, shank=3.0), "limbs.0.shank = 3.0: Input should be less than 3"),
        (set_limb(0, mass=0.0), "limbs.0.mass = 0.0: Input should be greater than 0"),
        (set_limb(0, abduction_inertia=-0.1), "limbs.0.abduction_inertia = -0.1: Input should be greater than 0"),
        (set_limb(0, hip=[0.3, 0.1]), "limbs.0.hip.2: missing"),
        (set_limb(0, calf=0.3), "limbs.0.calf = 0.3: unknown field; allowed: leg, hip, aside, below, thigh, shank,"),
        (
            set_limb(0, flexion_inertia=[[0.1, 0.02], [0.01, 0.1]]),
            "limbs.0: flexion_inertia = ((0.1, 0.02), (0.01, 0.1)): must be symmetric and positive definite [kg m^2]",
        ),
        (
            set_limb(0, flexion_inertia=[[0.1, 0.2], [0.2, 0.1]]),
            "limbs.0: flexion_inertia = ((0.1, 0.2), (0.2, 0.1)): ",
        ),
        (
            swapped,
            "limbs: are of the legs ('RF', 'LF', 'LH', 'RH'); allowed is one a leg, in their order: LF, RF, LH, RH",
        ),
        (lambda robot: robot.update(limbs=robot["limbs"][:3]), "limbs: are of the legs ('LF', 'RF', 'LH'); allowed is"),
    ],
)
def test_limbs_that_are_none(robot: Data, edit: Edit, said: str) -> None:
    edit(robot)
    assert refusal(Robot, robot).startswith(said)


def test_a_robot_in_the_plane_has_no_limbs(robot: Data) -> None:
    planar = load_robot(CONFIGS / "robots" / "half_cheetah.yaml").as_data()
    assert refusal(Robot, planar | {"limbs": robot["limbs"][:2]}) == (
        "limbs: need a robot with dimension 3; leave them out"
    )


def test_a_robot_without_limbs_is_the_data_that_it_was(robot: Data) -> None:
    del robot["limbs"]
    assert Robot.from_data(robot, "here").as_data() == robot


def test_mirrored_twice_is_the_limb_itself(robot: Data) -> None:
    limb = (Robot.from_data(robot, "here").limbs or ())[0]
    assert limb.mirrored("X").mirrored(limb.leg) == limb
    assert limb.mirrored(limb.leg) != limb


def without_limbs(data: Data) -> None:
    data["robot"] = {key: value for key, value in data["robot"].items() if key != "limbs"}


def in_the_plane(data: Data) -> None:
    data["robot"] = load_robot(CONFIGS / "robots" / "half_cheetah.yaml").as_data()
    data["swing_clearance"] = 0.0


@pytest.mark.parametrize(
    ("edit", "said"),
    [
        (
            without_limbs,
            "objective.joint_work = 1, joint_heat = 0.02: the robot anymal says nothing of its joints (limbs): "
            "`gaitflow robot import` it again",
        ),
        (
            in_the_plane,
            "objective.joint_work = 1, joint_heat = 0.02: need a robot with dimension 3, half_cheetah has 2; al",
        ),
        (
            lambda data: data["transcription"].update(integrator="euler"),
            "objective.joint_work = 1, joint_heat = 0.02: need another transcription.integrator than euler, such as",
        ),
        (
            lambda data: data.update(stances_per_leg=None),
            "objective.joint_work = 1, joint_heat = 0.02: need stances_per_leg = 1, as a leg's swing is one",
        ),
        (
            lambda data: data["tasks"]["axes"].update(acceleration=0.5),
            "tasks.axes.acceleration: its energy is not modelled; leave the axis or the energy out",
        ),
        (
            lambda data: data.update(swing_clearance=0.09),
            "swing_clearance = 0.09: the kinematic box lets a foot be 0.08 m above another; allowed is at most that",
        ),
        (
            lambda data: data.update(swing_clearance=-0.01),
            "swing_clearance = -0.01: Input should be greater than or eq",
        ),
        (
            lambda data: data["strategy"].update(name="bonmin"),
            "swing_clearance = 0.04: the strategy 'bonmin' knows no middle of a swing; allowed is 0",
        ),
        (
            lambda data: [data["strategy"].update(name="bonmin"), data.update(swing_clearance=0.0)],
            "objective.joint_work = 1, joint_heat = 0.02: the strategy 'bonmin' knows no swing's duration",
        ),
        (
            lambda data: data["objective"].update(joint_heat=-1.0),
            "objective.joint_heat = -1.0: Input should be greater",
        ),
    ],
)
def test_scenarios_that_energy_does_not_fit(energy: Data, edit: Edit, said: str) -> None:
    edit(energy)
    assert refusal(Scenario, energy).startswith(said)


def test_a_scenario_of_energy_is_the_data_that_it_is_read_from(energy: Data) -> None:
    scenario = Scenario.from_data(energy, "here")
    assert scenario.as_data() == energy
    assert scenario.objective.energy
    assert {"swing_clearance", "objective"} <= set(scenario.problem_data)
    assert scenario.problem_data["robot"]["limbs"] == energy["robot"]["limbs"]


@pytest.mark.parametrize("change", [
    {"swing_clearance": 0.05}, {"objective": {"joint_heat": 0.03, "joint_work": 1.0}}, {"thigh": 0.26},
    {"mass": 3.0},
])  # fmt: skip
def test_what_energy_depends_on_is_in_the_problems_digest(energy: Data, change: Data) -> None:
    before = Scenario.from_data(energy, "here").problem_digest
    if not set(change) <= set(energy):
        robot = dict(energy["robot"])
        for index in range(4):
            set_limb(index, **change)(robot)
        change = {"robot": robot}
    assert Scenario.from_data(energy | change, "here").problem_digest != before


def test_without_energy_a_problem_is_what_it_was_before_there_was_any() -> None:
    """Units of work are found by this digest: it is that of the robot without limbs."""
    scenario = load_scenario(CONFIGS / "scenarios" / "anymal-exact-vibration.yaml")
    assert scenario.problem_digest == "20ac9c15bf69e809bc6bcb0fb817d20e91a864bebe9708188a5f51b71e2dd3b4"
    data = scenario.as_data()
    assert not {"swing_clearance", "joint_heat", "joint_work"} & {*data, *data["objective"]}
    without_limbs(data)
    assert Scenario.from_data(data, "here").problem_digest == scenario.problem_digest


def test_energy_tells_the_directions_of_time_apart(energy: Data) -> None:
    """Of a body that is alike fore and aft; its legs may be built otherwise, and positive power is not symmetric."""
    robot = dict(energy["robot"], inertia=[[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.1]])
    robot["legs"] = [
        leg | {"default_foot": [np.sign(leg["default_foot"][0]) * 0.37, *leg["default_foot"][1:]]}
        for leg in robot["legs"]
    ]
    straight = Task.of({"speed": 0.5, "cycle_duration": 0.6})
    scenarios = [
        Scenario.from_data(energy | {"robot": robot, "objective": objective}, "here")
        for objective in ({"force": 1.0}, {"joint_heat": 0.02})
    ]
    assert [each.symmetry(straight).reversal for each in scenarios] == [(2, 3, 0, 1), None]
    assert [each.symmetry(straight).mirror for each in scenarios] == [(1, 0, 3, 2)] * 2
