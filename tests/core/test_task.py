from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from gaitflow.core.task import AXES, Task, span
from gaitflow.core.task_space import TaskSpace

values = st.fixed_dictionaries({name: st.floats(axis.low, axis.high) for name, axis in AXES.items()})
tasks = st.builds(Task.of, values, st.sampled_from(["grid", "held_out"]))


def signs(one: Task, other: Task) -> dict[str, bool]:
    """Which axes the other task has the opposite value on; the rest must be equal."""
    flipped = {axis: one[axis] != other[axis] for axis in AXES}
    assert all(other[axis] == (-one[axis] if flipped[axis] else one[axis]) for axis in AXES)
    return flipped


@given(values)
def test_a_task_has_a_value_on_every_axis(chosen: dict[str, float]) -> None:
    task = Task.of(chosen)
    assert {axis: task[axis] for axis in AXES} == chosen
    np.testing.assert_array_equal(task.parameters, [chosen[axis] for axis in AXES])
    assert (task.speed, task.cycle_duration) == (chosen["speed"], chosen["cycle_duration"])
    assert task.on(reversed(AXES)) == tuple(reversed(task.values))
    assert Task.of(dict(reversed(chosen.items()))) == task, "the order of the mapping is not the task's"


def test_what_nobody_gives_has_its_default() -> None:
    task = Task.of({"cycle_duration": 0.6})
    assert {axis: task[axis] for axis in AXES} == {
        name: 0.6 if name == "cycle_duration" else axis.default for name, axis in AXES.items()
    }
    assert task["friction"] == 0.8 and task.split == "grid"


@pytest.mark.parametrize(("chosen", "said"), [
    ({}, r"a task needs a cycle_duration \[s\]"),
    ({"cycle_duration": 0.6, "sped": 1.0}, "axis 'sped' is unknown; the axes are speed, lateral_speed,"),
    ({"cycle_duration": 0.6, "x" * 10_000: 1.0}, "axis 'x{80}' is unknown"),
    ({"cycle_duration": 0.0}, "cycle_duration = 0 s: must lie in 0.01 to 20 s"),
    ({"cycle_duration": 0.6, "slope": 60.0}, "slope = 60 deg: must lie in -59 to 59 deg"),
    ({"cycle_duration": math.nan}, "cycle_duration = nan s: must lie in"),
    ({"cycle_duration": 0.6, "speed": math.inf}, "speed = inf m/s: must lie in -20 to 20 m/s"),
])  # fmt: skip
def test_what_is_no_task_is_refused_in_one_line(chosen: dict[str, float], said: str) -> None:
    with pytest.raises(ValueError, match=said) as caught:
        Task.of(chosen)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 300


@given(tasks)
def test_images_undo_themselves_and_commute(task: Task) -> None:
    assert task.mirrored().mirrored() == task
    assert task.time_reversed().time_reversed() == task
    assert task.mirrored().time_reversed() == task.time_reversed().mirrored()
    for image in (task.mirrored(), task.time_reversed()):
        assert (image.speed, image.cycle_duration, image.split) == (task.speed, task.cycle_duration, task.split)
        assert np.abs(image.parameters).tobytes() == (np.abs(task.parameters) + 0.0).tobytes()


@given(tasks)
def test_what_an_image_turns_round(task: Task) -> None:
    assume(all(task.values))
    mirrored, backwards = signs(task, task.mirrored()), signs(task, task.time_reversed())
    assert {axis for axis, turned in mirrored.items() if turned} == {"lateral_speed", "yaw_rate"}
    assert {axis for axis, turned in backwards.items() if turned} == {"lateral_speed", "acceleration", "slope"}


def test_no_image_has_a_negative_zero() -> None:
    task = Task.of({"speed": 1.0, "cycle_duration": 0.6})
    for image in (task.mirrored(), task.time_reversed()):
        assert image.parameters.tobytes() == task.parameters.tobytes()


def test_a_value_can_be_replaced() -> None:
    task = Task.of({"speed": 1.0, "cycle_duration": 0.6}, "held_out")
    assert task.replaced(slope=5.0) == Task.of({"speed": 1.0, "cycle_duration": 0.6, "slope": 5.0}, "held_out")
    with pytest.raises(ValueError, match="slope = 90 deg"):
        task.replaced(slope=90.0)


def test_a_task_reads_well() -> None:
    task = Task.of({"speed": 0.9, "cycle_duration": 0.6, "slope": -12.5})
    assert task.text() == "speed 0.9 m/s, cycle_duration 0.6 s"
    assert task.text(("slope",)) == "slope -12.5 deg"
    assert task.text(("friction",)) == "friction 0.8"
    assert span("friction") == "0.01 to 5"
    assert span("yaw_rate") == "-10 to 10 rad/s"


def scenario(**axes: Any) -> dict[str, Any]:
    return {"tasks": {"axes": axes}}


RANGE = {"start": 0.1, "stop": 1.0, "count": 4}


def test_the_space_of_a_scenario() -> None:
    space = TaskSpace.of(scenario(friction=0.5, slope=RANGE, cycle_duration=0.6))
    assert space.ranged == ("slope",)
    assert dict(space.fixed) == {"cycle_duration": 0.6, "friction": 0.5}
    assert space.columns == ("speed", "cycle_duration", "slope")
    task = space.task({"slope": 0.3}, "held_out")
    assert task == Task.of({"slope": 0.3, "cycle_duration": 0.6, "friction": 0.5}, "held_out")
    assert space.task({"slope": 0.3, "cycle_duration": 0.6, "speed": 0.0}) == space.task({"slope": 0.3}), (
        "a fixed axis may be given with the value that it has, and a default with its own"
    )


@given(st.sets(st.sampled_from(list(AXES)), min_size=1), values)
def test_a_space_gives_back_the_ranged_values(ranged: set[str], chosen: dict[str, float]) -> None:
    axes = {axis: RANGE if axis in ranged else chosen[axis] for axis in AXES}
    space = TaskSpace.of(scenario(**axes))
    assert space.ranged == tuple(axis for axis in AXES if axis in ranged), "in the register's order"
    assert set(space.columns) == ranged | {"speed", "cycle_duration"}
    task = space.task({axis: chosen[axis] for axis in ranged})
    assert task == Task.of(chosen)
    assert space.task({axis: task[axis] for axis in space.columns}) == task, "the columns of a table make its task"


@pytest.mark.parametrize(("given_", "said"), [
    ({"slope": 0.3, "payload_": 1.0}, "axis 'payload_' is unknown here; the axes are slope"),
    ({"slope": 0.3, "friction": 0.4}, "friction = 0.4: it is fixed at 0.5 here; the axes are slope"),
    ({"slope": 0.3, "yaw_rate": 0.4}, "yaw_rate = 0.4: it is fixed at 0 rad/s here; the axes are slope"),
    ({}, "a task here needs slope as well; the axes are slope"),
    ({"slope": 80.0}, "slope = 80 deg: must lie in -59 to 59 deg"),
])  # fmt: skip
def test_an_axis_that_the_space_lacks(given_: dict[str, float], said: str) -> None:
    space = TaskSpace.of(scenario(friction=0.5, slope=RANGE, cycle_duration=0.6))
    with pytest.raises(ValueError) as caught:
        space.task(given_)
    assert str(caught.value) == said
