"""The rounds of an adaptive sampling, as they are written down: which tasks each one searches, and why."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from gaitflow.certificate.certificate import Certificate
from gaitflow.core.task import Split, Task
from gaitflow.core.task_space import TaskSpace

# known: of the dataset that the sampling begins from. start: spread over the box. doubt: where the map was least sure.
# certificate: drawn at random for a new certificate; more: the same certificate again, with more tasks.
Kind = Literal["known", "start", "doubt", "certificate", "more"]
KINDS: tuple[Kind, ...] = ("known", "start", "doubt", "certificate", "more")


@dataclass(frozen=True)
class Round:
    """Tasks that are searched together. `certificate` is what the asking came to; None before, and for other kinds.

    askings: how often certificates were asked with the searches of a dataset, of the kind "known". Raises ValueError
    when it is negative.
    """

    kind: Kind
    tasks: tuple[Task, ...]
    certificate: Certificate | None = None
    askings: int = 0

    def __post_init__(self) -> None:
        if self.askings < 0:
            raise ValueError(f"askings = {self.askings}: certificates cannot be asked fewer than 0 times")

    @property
    def of_certificate(self) -> bool:
        """Whether its tasks were drawn to judge the map, not to make it."""
        return self.kind in ("certificate", "more")

    def as_data(self, space: TaskSpace) -> dict[str, Any]:
        """Plain JSON data: a task by its values on the axes with a range."""
        data: dict[str, Any] = {"kind": self.kind, "tasks": [list(task.on(space.ranged)) for task in self.tasks]}
        data |= {"askings": self.askings} if self.askings else {}
        return data if self.certificate is None else data | {"certificate": self.certificate.as_data()}


def rounds_from(data: Any, space: TaskSpace) -> list[Round]:
    """Rounds from plain JSON data. Raises ValueError for anything else."""
    try:
        return [
            Round(
                KINDS[KINDS.index(one["kind"])],
                tuple(task_at(space, values) for values in one["tasks"]),
                Certificate(**one["certificate"]) if "certificate" in one else None,
                int(one.get("askings", 0)),
            )
            for one in data
        ]
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise ValueError(f"these are no rounds of a sampling over {', '.join(space.ranged)}: {error!r}") from None


def task_at(space: TaskSpace, values: Any, split: Split = "sampled") -> Task:
    """The task with these values on the axes with a range."""
    return space.task(dict(zip(space.ranged, values, strict=True)), split)


def askings(rounds: Sequence[Round]) -> int:
    """How often certificates were asked, before the dataset that a sampling begins from was published as well."""
    return sum(one.askings + (one.certificate is not None) for one in rounds)


def was_stopped(rounds: Sequence[Round], searched: Collection[Task]) -> bool:
    """Whether the last round was not gone through: a task is not searched, or its certificate not asked."""
    if not rounds:
        return False
    last = rounds[-1]
    return not set(last.tasks) <= set(searched) or (last.of_certificate and last.certificate is None)


def held_out(rounds: list[Round]) -> set[Task]:
    """The tasks of the last certificate, if nothing was made from them since."""
    tasks: set[Task] = set()
    for one in reversed(rounds):
        if not one.of_certificate:
            break
        tasks |= set(one.tasks)
        if one.kind == "certificate":
            break
    return tasks
