"""What figures and tables call the axes of a task: their usual symbols, with units."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from gaitflow.core.task import AXES, Task

# Of axes without a symbol of their own the name does.
_SYMBOLS = {"speed": "v", "lateral_speed": "v_y", "acceleration": "a", "cycle_duration": "T", "friction": "mu"}
_UNITS = {"deg": "°", "m/s^2": "m/s²", "1": ""}


def words(axis: str) -> str:
    """The name as words: "cycle duration"."""
    return axis.replace("_", " ")


def unit(axis: str) -> str:
    """The unit as it is printed, "" for a number without one."""
    own = AXES[axis].unit
    return _UNITS.get(own, own)


def symbol(axis: str) -> str:
    """The symbol, or the words where there is none: "T", "slope"."""
    return _SYMBOLS.get(axis, words(axis))


def heading(axis: str) -> str:
    """Of a table's column: "T [s]"."""
    return f"{symbol(axis)} [{unit(axis)}]" if unit(axis) else symbol(axis)


def label(axis: str) -> str:
    """Of a figure's axis: "cycle duration T [s]"."""
    return f"{words(axis)} {heading(axis)}" if axis in _SYMBOLS else heading(axis)


def quantity(axis: str, value: float) -> str:
    """A value with its unit: "0.8 s", "-20°"."""
    own = unit(axis)
    return f"{value:.4g}{own}" if own in ("", "°") else f"{value:.4g} {own}"


def values(task: Task | Mapping[str, float], axes: Iterable[str]) -> str:
    """Values on some axes: "v = 0.3 m/s, T = 0.8 s"."""
    return ", ".join(f"{symbol(axis)} = {quantity(axis, task[axis])}" for axis in axes)


def values_in_words(task: Task | Mapping[str, float], axes: Iterable[str]) -> str:
    """Values on some axes, without symbols: "lateral speed = 0.2 m/s, slope = 8°"."""
    return ", ".join(f"{words(axis)} = {quantity(axis, task[axis])}" for axis in axes)
