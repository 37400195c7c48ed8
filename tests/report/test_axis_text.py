"""What figures and tables call the axes of a task."""

from __future__ import annotations

from gaitflow.core.task import AXES, Task
from gaitflow.report import axis_text


def test_axes_have_symbols_and_units() -> None:
    assert axis_text.label("cycle_duration") == "cycle duration T [s]"
    assert axis_text.heading("speed") == "v [m/s]"
    assert (axis_text.label("slope"), axis_text.heading("friction")) == ("slope [°]", "mu")
    assert [axis_text.quantity("slope", -20.0), axis_text.quantity("speed", 0.123456)] == ["-20°", "0.1235 m/s"]
    task = Task.of({"speed": 0.3, "cycle_duration": 0.8})
    assert axis_text.values(task, ("speed", "cycle_duration")) == "v = 0.3 m/s, T = 0.8 s"


def test_every_axis_of_the_register_has_its_own_words() -> None:
    for text in (axis_text.label, axis_text.heading, axis_text.words):
        said = {text(axis) for axis in AXES}
        assert len(said) == len(AXES) and not any(
            "_" in one for one in said - {axis_text.heading("lateral_speed"), axis_text.label("lateral_speed")}
        )
