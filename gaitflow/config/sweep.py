"""A sweep: one scenario over many robots, whose parameters are sampled within ranges.

A sweep file says which parameters have which ranges, and how many robots to draw. `sampled` joins it with a scenario:
each sample is a whole scenario again, checked as if somebody had written it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag, field_validator

from gaitflow.config.axes import Range
from gaitflow.config.file import FORMS, Config, ConfigError, FrozenDict, meant, read_yaml
from gaitflow.config.parameters import Change, changed, numbers
from gaitflow.config.scenario import Scenario
from gaitflow.core.task import AXES

SAMPLED_DIGITS, ROBOT_DIGITS = 6, 9  # significant ones, so that a robot prints as it was solved

Positive = Annotated[float, Field(gt=0)]


class Factor(Config):
    """What every number of a parameter is multiplied by, even in its logarithm: half is as near as double."""

    factor: tuple[Positive, Positive]


def _form(given: Any) -> str:
    return FORMS[0] if isinstance(given, (Mapping, Factor)) else FORMS[1]


Span = Factor | tuple[float, float]
Sampled = Annotated[
    Annotated[Factor, Tag(FORMS[0])] | Annotated[tuple[float, float], Tag(FORMS[1])], Discriminator(_form)
]


class Sweep(Config):
    """Which parameters of a scenario are sampled where, and how often. Frozen.

    A parameter is one of the robot (see `gaitflow.config.parameters`), or an axis of tasks that the scenario fixes,
    such as friction.
    """

    name: Annotated[str, Field(pattern=r"^[a-z0-9]+(-[a-z0-9]+)*$", max_length=80)]
    description: str = ""
    samples: Annotated[int, Field(ge=1, le=10_000)]
    seed: Annotated[int, Field(ge=0)] = 0
    ranges: Annotated[dict[str, Sampled], Field(min_length=1)]  # [low, high], or {factor: [low, high]}
    axes: dict[str, Range] = Field(default_factory=FrozenDict)  # in place of ranges of the tasks: a coarser grid

    @field_validator("ranges")
    @classmethod
    def _ordered(cls, ranges: dict[str, Span]) -> dict[str, Span]:
        for name, span in ranges.items():
            low, high = _ends(span)
            if not low < high:
                raise ValueError(f"{name} = [{low:g}, {high:g}]: the first number must be below the second")
        return FrozenDict(ranges)

    @field_validator("axes")
    @classmethod
    def _frozen(cls, axes: dict[str, Range]) -> dict[str, Range]:
        return FrozenDict(axes)


@dataclass(frozen=True)
class Sample:
    """One robot of a sweep: its number from 0, what was drawn for each parameter, and the whole scenario with it."""

    number: int
    values: Mapping[str, float]
    scenario: Scenario


def load_sweep(path: Path) -> Sweep:
    """Read a sweep YAML. Raises ConfigError that names the file, the field, the value and what is allowed."""
    return Sweep.from_data(read_yaml(path), str(path))


def sampled(scenario: Scenario, sweep: Sweep) -> tuple[Sample, ...]:
    """The scenario with every robot of the sweep, without held-out tasks; asking for more robots keeps the first ones.

    Values are those of a scrambled Sobol sequence, rounded to 6 digits. Raises ConfigError for a parameter or axis that
    the scenario has not, and for a robot that cannot be: each range is tried at both of its ends, then every sample.
    """
    data = _on_axes(scenario, sweep)
    for name, span in sweep.ranges.items():
        _check_numbers(data, name, span, f"sweep {sweep.name}: ranges.{name}")
        for end, value in zip(("low", "high"), _ends(span), strict=True):
            _with_values(data, sweep, {name: value}, f"sweep {sweep.name}: ranges.{name}, {end} end {value:g}")
    samples = []
    for number, values in enumerate(_drawn(sweep)):
        told = ", ".join(f"{name} {value:g}" for name, value in values.items())
        one = _with_values(data, sweep, values, f"sweep {sweep.name}: sample {number} ({told})")
        samples.append(Sample(number, FrozenDict(values), one))
    return tuple(samples)


def _drawn(sweep: Sweep) -> list[dict[str, float]]:
    from scipy.stats import qmc

    power = math.ceil(math.log2(sweep.samples))  # only powers of two are balanced; a longer sequence begins alike
    points = qmc.Sobol(len(sweep.ranges), rng=sweep.seed).random_base2(power)[: sweep.samples]
    dimensions = {name: place for place, name in enumerate(sorted(sweep.ranges))}  # whatever the file's order is
    return [{name: _at(span, row[dimensions[name]]) for name, span in sweep.ranges.items()} for row in points]


def _at(span: Span, share: float) -> float:
    """The value at a share of a range, from 0 to 1."""
    low, high = _ends(span)
    value = low * (high / low) ** share if isinstance(span, Factor) else low + (high - low) * share
    return min(max(_rounded(value, SAMPLED_DIGITS), low), high)


def _ends(span: Span) -> tuple[float, float]:
    return span.factor if isinstance(span, Factor) else span


def _rounded(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")


def _on_axes(scenario: Scenario, sweep: Sweep) -> dict[str, Any]:
    """The scenario's data on the sweep's tasks. Raises ConfigError for an axis that has no range there."""
    data, ranges = scenario.as_data(), scenario.tasks.ranges
    for axis in sweep.axes:
        if axis not in ranges:
            raise ConfigError(
                f"sweep {sweep.name}: axes.{axis}: has no range in {scenario.name}{meant(axis, ranges)} allowed: "
                f"{', '.join(ranges)}"
            )
    axes = data["tasks"]["axes"] | {axis: values.as_data() for axis, values in sweep.axes.items()}
    return data | {"tasks": {"axes": axes}}  # and none held out: nothing is learnt from a sweep


def _check_numbers(data: dict[str, Any], name: str, span: Span, source: str) -> None:
    """Raises ConfigError unless the parameter is a fixed axis, one number of the robot, or several to be multiplied."""
    if name in AXES:
        if isinstance(data["tasks"]["axes"].get(name), Mapping):
            raise ConfigError(f"{source}: has a range in the scenario; only an axis that it fixes can be sampled")
        return
    try:
        count = len(numbers(data["robot"], name))
    except LookupError as error:
        raise ConfigError(f"{source}: {error.args[0]}") from None
    if count > 1 and not isinstance(span, Factor):
        raise ConfigError(
            f"{source} = {list(span)}: it is {count} numbers of the robot; write {{factor: [low, high]}} to multiply "
            "them, or name one"
        )


def _with_values(data: dict[str, Any], sweep: Sweep, values: Mapping[str, float], source: str) -> Scenario:
    robot, axes = data["robot"], dict(data["tasks"]["axes"])
    for name, value in values.items():
        change = _change(sweep.ranges[name], value)
        if name in AXES:
            axes[name] = change(_fixed(axes, name))
        else:
            robot = changed(robot, name, change)
    try:
        return Scenario.from_data(data | {"robot": robot, "tasks": data["tasks"] | {"axes": axes}}, source)
    except ConfigError as error:
        raise ConfigError(str(error).splitlines()[0]) from None


def _fixed(axes: Mapping[str, Any], name: str) -> float:
    value = axes.get(name, AXES[name].default)
    assert value is not None, "no scenario is without the axis that has no default"
    return float(value)


def _change(span: Span, value: float) -> Change:
    if isinstance(span, Factor):
        return lambda number: _rounded(number * value, ROBOT_DIGITS)
    return lambda number: value
