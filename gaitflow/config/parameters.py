"""The numbers of a robot by name, dotted as its file is nested: `mass`, `box.z`, `legs.default_foot.x`.

`legs.F.default_foot.x` is one leg's number, `legs.default_foot.x` that of every leg, `inertia` all of a matrix.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from gaitflow.config.file import meant

COORDINATES = {2: ("x", "z"), 3: ("x", "y", "z")}

Change = Callable[[float], float]


def numbers(robot: Mapping[str, Any], name: str) -> tuple[float, ...]:
    """All numbers that a name stands for; `robot` is `Robot.as_data()`. Raises LookupError as `changed` does."""
    found: list[float] = []

    def noted(number: float) -> float:
        found.append(number)
        return number

    changed(robot, name, noted)
    return tuple(found)


def changed(robot: Mapping[str, Any], name: str, change: Change) -> dict[str, Any]:
    """The robot with every number that the name stands for changed.

    Raises LookupError that says what is allowed where there is no such name, or no number.
    """
    return _changed(robot, name.split("."), change, COORDINATES[robot["dimension"]])


def _changed(data: Any, steps: Sequence[str], change: Change, coordinates: Sequence[str]) -> Any:
    if isinstance(data, list) and data and isinstance(data[0], Mapping):  # legs, limbs
        named = {item.get("name", item.get("leg")): item for item in data}
        chosen, rest = ({steps[0]}, steps[1:]) if steps and steps[0] in named else (set(named), steps)
        return [_changed(item, rest, change, coordinates) if leg in chosen else item for leg, item in named.items()]
    if not steps:
        return _number(data, change)
    step, *rest = steps
    if isinstance(data, list) and len(data) == len(coordinates) and not isinstance(data[0], list):
        places = dict(zip(coordinates, data, strict=True))
        return list((places | {step: _changed(_found(places, step), rest, change, coordinates)}).values())
    found = _found(data if isinstance(data, Mapping) else {}, step)
    return {**data, step: _changed(found, rest, change, coordinates)}


def _number(data: Any, change: Change) -> Any:
    if isinstance(data, list) and data:
        return [_number(item, change) for item in data]
    if isinstance(data, bool) or not isinstance(data, (int, float)):
        raise LookupError("is no number of the robot; allowed are numbers, such as mass, box.z, legs.default_foot.x")
    return change(data)


def _found(data: Mapping[str, Any], step: str) -> Any:
    if step in data:
        return data[step]
    allowed = f"{meant(step, data)} allowed: {', '.join(data)}" if data else "; nothing is below it"
    raise LookupError(f"no {step!r} there{allowed}")
