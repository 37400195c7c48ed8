"""Sweeps: which robots are drawn, and which are refused before any work starts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitflow import shipped
from gaitflow.config.file import ConfigError
from gaitflow.config.parameters import changed, numbers
from gaitflow.config.robot import load_robot
from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.config.sweep import Factor, Sweep, load_sweep, sampled
from gaitflow.core.task import Task

RANGES: dict[str, Any] = {
    "legs.default_foot.x": {"factor": [0.5, 2.0]},
    "box.z": [0.05, 0.2],
    "inertia": {"factor": [0.5, 4.0]},
    "friction": [0.5, 1.0],
}


def sweep_of(**changes: Any) -> Sweep:
    return Sweep.from_data({"name": "test", "samples": 5, "ranges": RANGES} | changes, "test.yaml")


@pytest.fixture(scope="module")
def exact() -> Scenario:
    return load_scenario(shipped.SCENARIOS / "half-cheetah-exact-effort.yaml")


def test_a_seed_decides_the_robots_and_more_samples_keep_the_first(exact: Scenario) -> None:
    few, same = sampled(exact, sweep_of()), sampled(exact, sweep_of())
    assert few == same
    assert sampled(exact, sweep_of(samples=11))[:5] == few
    assert sampled(exact, sweep_of(seed=1)) != few


def test_the_order_of_the_ranges_decides_nothing(exact: Scenario) -> None:
    backwards = sweep_of(ranges=dict(reversed(RANGES.items())))
    assert [one.scenario for one in sampled(exact, backwards)] == [one.scenario for one in sampled(exact, sweep_of())]


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 1000),
    low=st.floats(0.01, 1.0),
    width=st.floats(0.01, 3.0),
    form=st.sampled_from(["value", "factor"]),
)
def test_samples_lie_in_their_ranges_and_reach_both_halves(seed: int, low: float, width: float, form: str) -> None:
    scenario = load_scenario(shipped.SCENARIOS / "half-cheetah-exact-effort.yaml")
    span: Any = [low, low + width] if form == "value" else {"factor": [low, low + width]}
    drawn = sampled(scenario, sweep_of(samples=8, seed=seed, ranges={"mass": span, "max_force": [100.0, 200.0]}))
    values = np.array([one.values["mass"] for one in drawn])
    assert (low <= values).all() and (values <= low + width).all()
    middle = low + width / 2 if form == "value" else np.sqrt(low * (low + width))
    assert np.abs((values < middle).sum() - 4) <= 1, "balanced, but for a value that is rounded over the middle"
    masses = [one.scenario.robot.mass for one in drawn]
    assert masses == pytest.approx(values if form == "value" else 14.0 * values, rel=1e-6)


def test_a_sample_is_the_scenario_with_another_robot_on_the_sweep_s_tasks(exact: Scenario) -> None:
    axes = {"speed": {"start": 0.5, "stop": 1.5, "count": 2}}
    for one in sampled(exact, sweep_of(axes=axes)):
        robot = one.scenario.robot
        feet = [leg.default_foot for leg in robot.legs]
        assert feet[0][0] == -feet[1][0] == pytest.approx(0.3 * one.values["legs.default_foot.x"])
        assert [foot[1] for foot in feet] == [-0.5, -0.5]
        assert robot.inertia == ((pytest.approx(0.3 * one.values["inertia"]),),)
        assert robot.box == (0.2, one.values["box.z"])
        assert one.scenario.tasks.axes["friction"] == one.values["friction"]
        assert one.scenario.tasks.ranges["speed"].values == (0.5, 1.5)
        assert one.scenario.tasks.ranges["cycle_duration"] == exact.tasks.ranges["cycle_duration"]
        assert one.scenario.tasks.held_out == 0
        # Gaits are merged under time reversal only for a robot that is its own image to the last bit.
        task = Task.of({"speed": 0.5, "cycle_duration": 0.6})
        assert one.scenario.symmetry(task).reversal == (1, 0)
        beside = {"robot", "tasks"}
        assert one.scenario.model_dump(exclude=beside) == exact.model_dump(exclude=beside)


def test_all_robots_are_asked_on_one_grid_whatever_the_scenario_says_of_its_tasks(exact: Scenario) -> None:
    data = exact.as_data()
    chosen = data["tasks"] | {"sampling": "adaptive", "held_out": 0}
    adaptive = Scenario.from_data(data | {"tasks": chosen}, "test")
    assert [one.scenario for one in sampled(adaptive, sweep_of())] == [
        one.scenario for one in sampled(exact, sweep_of())
    ]


REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"mass": [-3.0, 4.0]}, "sweep test: ranges.mass, low end -3: robot.mass = -3.0: Input should be greater than 0"),
    (
        {"box.z": [0.1, 0.6]},
        "sweep test: ranges.box.z, high end 0.6: robot: legs.F.default_foot = (0.3, -0.5): with box = (0.2, 0.6) the "
        "foot's box reaches up to the base; its z must be below -0.6",
    ),
    (
        {"friction": [-1.0, 1.0]},
        "sweep test: ranges.friction, low end -1: tasks.axes: friction = -1: must lie in 0.01 to 5",
    ),
    (
        {"legs.default_foot.x": [0.1, 0.2]},
        "sweep test: ranges.legs.default_foot.x = [0.1, 0.2]: it is 2 numbers of the robot; write "
        "{factor: [low, high]} to multiply them, or name one",
    ),
    ({"legs.G.default_foot.x": [0.1, 0.2]}, "sweep test: ranges.legs.G.default_foot.x: no 'G' there"),
    ({"mas": [1.0, 2.0]}, "sweep test: ranges.mas: no 'mas' there, did you mean mass?"),
    ({"box.y": [0.1, 0.2]}, "sweep test: ranges.box.y: no 'y' there; allowed: x, z"),
    ({"mass.x": [0.1, 0.2]}, "sweep test: ranges.mass.x: no 'x' there; nothing is below it"),
    ({"name": [0.1, 0.2]}, "sweep test: ranges.name: is no number of the robot"),
    ({"mirror": [0.1, 0.2]}, "sweep test: ranges.mirror: is no number of the robot"),
    ({"speed": [0.1, 0.2]}, "sweep test: ranges.speed: has a range in the scenario"),
]


@pytest.mark.parametrize(("ranges", "message"), REFUSED, ids=[next(iter(ranges)) for ranges, _ in REFUSED])
def test_a_range_that_makes_no_robot_is_refused_in_one_line(
    ranges: dict[str, Any], message: str, exact: Scenario
) -> None:
    with pytest.raises(ConfigError) as refused:
        sampled(exact, sweep_of(ranges=ranges))
    assert str(refused.value).startswith(message)
    assert "\n" not in str(refused.value)


def test_a_sample_whose_parameters_do_not_fit_together_is_refused_by_number(exact: Scenario) -> None:
    ranges = {"box.z": [0.1, 0.45], "legs.default_foot.z": {"factor": [0.7, 1.0]}}
    with pytest.raises(ConfigError) as refused:
        sampled(exact, sweep_of(samples=64, ranges=ranges))
    assert "\n" not in str(refused.value)
    assert str(refused.value).startswith("sweep test: sample ")
    assert "box.z 0.4" in str(refused.value) and "its z must be below -0.4" in str(refused.value)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"ranges": {}}, "test.yaml: ranges"),
        ({"ranges": {"mass": [3.0, 2.0]}}, "test.yaml: ranges: mass = [3, 2]: the first number must be below"),
        (
            {"ranges": {"mass": {"factor": [0.0, 2.0]}}},
            "test.yaml: ranges.mass.factor.0 = 0.0: Input",
        ),
        ({"samples": 0}, "test.yaml: samples = 0"),
        ({"colour": "red"}, "test.yaml: colour = 'red': unknown field"),
    ],
)
def test_a_bad_file_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError) as refused:
        sweep_of(**changes)
    assert str(refused.value).startswith(message)


def test_an_axis_that_the_scenario_fixes_gets_no_range(exact: Scenario) -> None:
    axes = {"slope": {"start": 0.0, "stop": 10.0, "count": 2}}
    with pytest.raises(ConfigError, match=r"^sweep test: axes\.slope: has no range in half-cheetah-exact-effort"):
        sampled(exact, sweep_of(axes=axes))


def test_the_sweeps_that_ship_fit_their_scenarios() -> None:
    files = sorted(shipped.SWEEPS.glob("*.yaml"))
    assert files
    for file in files:
        sweep = load_sweep(file)
        assert sweep.name == file.stem
        for scenario in sorted(shipped.SCENARIOS.glob(f"{sweep.name}-*-effort.yaml")):
            assert len(sampled(load_scenario(scenario), sweep)) == sweep.samples
            assert all(isinstance(span, (Factor, tuple)) for span in sweep.ranges.values())


def test_names_reach_a_robot_in_space() -> None:
    robot = load_robot(shipped.ROBOTS / "anymal.yaml").as_data()
    assert len(numbers(robot, "inertia")) == 9
    assert len(numbers(robot, "legs.default_foot.y")) == 4
    assert numbers(robot, "legs.LF.default_foot.z") == (robot["legs"][0]["default_foot"][2],)
    assert numbers(robot, "limbs.LF.mass") == (robot["limbs"][0]["mass"],)
    wider = changed(robot, "legs.default_foot.y", lambda y: 2 * y)
    assert numbers(wider, "legs.default_foot.y") == tuple(2 * y for y in numbers(robot, "legs.default_foot.y"))
    assert wider | {"legs": robot["legs"]} == robot


def test_a_file_is_read(tmp_path: Path) -> None:
    file = tmp_path / "own.yaml"
    file.write_text("name: own\nsamples: 2\nranges: {mass: [10.0, 20.0], inertia: {factor: [0.5, 2.0]}}\n")
    sweep = load_sweep(file)
    assert sweep.ranges == {"mass": (10.0, 20.0), "inertia": Factor(factor=(0.5, 2.0))}
    assert hash(sweep) == hash(load_sweep(file))
