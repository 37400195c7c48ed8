"""The axes of a scenario's tasks: which of them range over what, and at which values the others are fixed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from difflib import get_close_matches
from reprlib import repr as short
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    Discriminator,
    Field,
    SerializerFunctionWrapHandler,
    Tag,
    field_validator,
    model_serializer,
    model_validator,
)

from gaitflow.config.file import FORMS, Config, FrozenDict
from gaitflow.config.sampling import Sampling
from gaitflow.core.task import AXES, span
from gaitflow.core.task_space import TaskSpace

MAX_GRID = 1_000_000  # tasks


class Range(Config):
    """`count` evenly spaced values from `start` to `stop`, both included."""

    start: float
    stop: float
    count: Annotated[int, Field(ge=1, le=10_000)]

    @model_validator(mode="after")
    def _ordered(self) -> Range:
        if self.stop < self.start or (self.count > 1 and self.stop == self.start):
            raise ValueError(
                f"stop = {self.stop:g}, start = {self.start:g}, count = {self.count}: stop must be above start "
                "(equal only when count is 1)"
            )
        return self

    @property
    def values(self) -> tuple[float, ...]:
        """The values, rounded to 1e-9 so that a task prints as it was written."""
        return tuple(round(float(x), 9) for x in np.linspace(self.start, self.stop, self.count))


def _form(given: Any) -> str:
    """Whether an axis is given by a range or by a value: so an error is about the one that was meant."""
    return FORMS[0] if isinstance(given, (Mapping, Range)) else FORMS[1]


AxisValues = Annotated[Annotated[Range, Tag(FORMS[0])] | Annotated[float, Tag(FORMS[1])], Discriminator(_form)]


def _choice(given: Any) -> str:
    """Whether a sampling is given by its settings or by its name."""
    return FORMS[0] if isinstance(given, (Mapping, Sampling)) else FORMS[1]


Choice = Annotated[
    Annotated[Sampling, Tag(FORMS[0])] | Annotated[Literal["grid", "adaptive"], Tag(FORMS[1])], Discriminator(_choice)
]


class Tasks(Config):
    """A range or a fixed value for the axes of a task (`gaitflow.core.task.AXES`), and held-out tasks between.

    The grid is the product of the ranges. An axis that is not named has its default; cycle_duration has none.
    All tasks of the grid are searched, or with a `sampling` those that it chooses anywhere between: then the grid is
    where gaits are spread to, and what the domain is told by.
    """

    axes: Annotated[dict[str, AxisValues], Field(json_schema_extra={"propertyNames": {"enum": list(AXES)}})]
    held_out: Annotated[int, Field(ge=0, le=100_000)] = 0
    held_out_seed: int = 0
    sampling: Choice = "grid"  # adaptive: as a `Sampling` of which nothing is said

    @field_validator("axes")
    @classmethod
    def _physical(cls, axes: dict[str, Range | float]) -> dict[str, Range | float]:
        for name, values in axes.items():
            if name not in AXES:
                meant = get_close_matches(name, AXES, 1)
                hint = f"did you mean {meant[0]}? " if meant else ""
                raise ValueError(f"{short(name)}: unknown axis; {hint}The axes are {', '.join(AXES)}")
            ends = (values.start, values.stop) if isinstance(values, Range) else (values,)
            for value in ends:
                if not AXES[name].admits(value):
                    raise ValueError(f"{name} = {value:g}: must lie in {span(name)}")
        if "cycle_duration" not in axes:
            raise ValueError("cycle_duration: missing; give it a value [s] or a range {start, stop, count}")
        if not any(isinstance(values, Range) for values in axes.values()):
            raise ValueError("no axis has a range: a map needs one at least, written {start, stop, count}")
        size = math.prod(values.count for values in axes.values() if isinstance(values, Range))
        if size > MAX_GRID:
            raise ValueError(f"the grid of all ranges has {size} tasks: at most {MAX_GRID} are allowed")
        return FrozenDict({name: axes[name] for name in AXES if name in axes})

    @model_validator(mode="after")
    def _no_held_out_tasks_of_a_sampling(self) -> Tasks:
        if self.adaptive is not None and self.held_out:
            raise ValueError(
                f"held_out = {self.held_out}: with an adaptive sampling the certificate's tasks are held out; leave it "
                "out"
            )
        return self

    @model_serializer(mode="wrap")
    def _without_grid(self, data: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Tasks on a grid are the same data as before there was a choice."""
        found: dict[str, Any] = data(self)
        return {key: found[key] for key in found if key != "sampling" or self.sampling != "grid"}

    @property
    def adaptive(self) -> Sampling | None:
        """How the tasks are chosen; None for all tasks of a grid."""
        if isinstance(self.sampling, Sampling):
            return self.sampling
        return Sampling() if self.sampling == "adaptive" else None

    @property
    def ranges(self) -> dict[str, Range]:
        """The axes that have a range, in the order of AXES."""
        return {name: values for name, values in self.axes.items() if isinstance(values, Range)}

    def varies(self, axis: str) -> bool:
        """Whether an axis has a range, or is fixed at another value than 0."""
        return self.axes.get(axis, AXES[axis].default) != 0

    @property
    def space(self) -> TaskSpace:
        """Which axes have a range, and the values of the fixed ones."""
        return TaskSpace.of({"tasks": self.as_data()})
