"""How a cluster is to be used, as data: `slurm/profiles/NAME.yaml`. The scenario is the same as on a laptop.

What ends in the text of a job's script is either validated here to be one plain word, or it is the user's own shell
(`setup`), which goes in as it is, a line each.
"""

from __future__ import annotations

import re
from pathlib import Path
from reprlib import repr as short
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)

from gaitflow.config.directives import LINE_BREAKS, Directive, foreign_directive
from gaitflow.config.file import Config, read_yaml

MAX_JOBS = 10_000
MAX_MARGIN = 0.5  # of the walltime
_WALLTIME = re.compile(r"(?:(\d{1,3})-)?(\d{1,3}):([0-5]\d):([0-5]\d)")
MIN_DRIVER_S = 300  # it is told to stop a minute before its end, and Slurm may say so a minute early


def _walltime(text: str) -> str:
    if walltime_seconds(text) < 60:
        raise ValueError(f'{short(text)}: at least one minute, "00:01:00"')
    return text


def walltime_seconds(text: str) -> int:
    """Seconds in "HH:MM:SS" or "D-HH:MM:SS". Raises ValueError for anything else."""
    match = _WALLTIME.fullmatch(text)
    if match is None:
        raise ValueError(f'{short(text)}: must be "HH:MM:SS" or "D-HH:MM:SS", such as "48:00:00" or "2-00:00:00"')
    days, hours, minutes, seconds = (int(part or 0) for part in match.groups())
    return ((days * 24 + hours) * 60 + minutes) * 60 + seconds


def _memory(text: str) -> str:
    if not re.fullmatch(r"[1-9][0-9]{0,5}[MGT]B", text):
        raise ValueError(f"{short(text)}: must be a whole number of MB, GB or TB without a space, such as 2GB")
    return text


def _quoted(value: Any) -> Any:
    if isinstance(value, int | float) and not isinstance(value, bool):
        raise ValueError(f'{short(value)} is a number to YAML: write the time in quotes, such as "48:00:00"')
    return value


def _one_line(text: str) -> str:
    if not text.strip() or LINE_BREAKS.search(text):
        raise ValueError(f"{short(text)}: must be one line of shell; give several lines as several items")
    return text


def _driver_walltime(text: str) -> str:
    if walltime_seconds(text) < MIN_DRIVER_S:
        raise ValueError(f'{short(text)}: at least five minutes for the driver, "00:05:00"')
    return text


Walltime = Annotated[str, BeforeValidator(_quoted), AfterValidator(_walltime)]
Memory = Annotated[str, AfterValidator(_memory)]
Word = Annotated[str, Field(pattern=r"^[A-Za-z0-9_][A-Za-z0-9_.,@+-]*$", max_length=200)]
# A folder of the node: absolute, or below a variable that the node sets, such as $TMPDIR or /scratch/$USER.
NodeFolder = Annotated[
    str, Field(pattern=r"^(/|\$)([A-Za-z0-9_./+-]|\$[A-Za-z_][A-Za-z0-9_]*|\$\{[A-Za-z_][A-Za-z0-9_]*\})*$")
]


class Driver(Config):
    """The small job that runs the workflow: it plans, hands out units and trains, and solves nothing itself."""

    walltime: Annotated[Walltime, AfterValidator(_driver_walltime)] = "2-00:00:00"
    memory: Memory = "4GB"
    partition: Word | None = None  # null: that of the workers
    directives: tuple[Directive, ...] | None = None  # null: those of the workers

    @property
    def walltime_s(self) -> int:
        """The walltime [s]."""
        return walltime_seconds(self.walltime)


class Profile(Config):
    """One cluster and how much of it to use. Memory is for a job (1GB = 2^30 bytes).

    `jobs` workers of one process and one thread each are kept in the queue; `cores` only reserves, for sites that
    hand out nothing smaller. `margin_s` is kept free at the end of a walltime, beside the longest unit.
    """

    name: Annotated[str, Field(pattern=r"^[a-z0-9]+(-[a-z0-9]+)*$", max_length=80)]
    scheduler: Literal["slurm", "pbs"] = "slurm"
    partition: Word | None = None
    account: Word | None = None
    walltime: Walltime
    memory: Memory = "2GB"
    jobs: Annotated[int, Field(ge=1, le=MAX_JOBS)]
    cores: Annotated[int, Field(ge=1, le=1024)] = 1
    scratch: NodeFolder | None = None
    setup: tuple[Annotated[str, AfterValidator(_one_line)], ...] = ()
    directives: tuple[Directive, ...] = ()
    interface: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$", max_length=15)] | None = None
    driver: Driver = Driver()
    margin_s: Annotated[float, Field(ge=0)] = 120.0
    tls: bool = True

    @property
    def walltime_s(self) -> int:
        """The walltime of a worker [s]."""
        return walltime_seconds(self.walltime)

    @model_validator(mode="after")
    def _margin_fits(self) -> Self:
        if self.margin_s > MAX_MARGIN * self.walltime_s:
            raise ValueError(
                f"margin_s = {self.margin_s:g}: must be at most half of the walltime, {self.walltime} "
                f"= {self.walltime_s} s; make the walltime longer or the margin smaller"
            )
        return self

    @model_validator(mode="after")
    def _directives_are_the_scheduler_s(self) -> Self:
        fault = foreign_directive(self.scheduler, self.directives)
        if fault is None and (fault := foreign_directive(self.scheduler, self.driver.directives or ())):
            fault = f"driver.{fault}"
        if fault is not None:
            raise ValueError(fault)
        return self

    @model_serializer(mode="wrap")
    def _without_unused(self, data: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Profiles for Slurm are the same data as before there was another scheduler."""
        found: dict[str, Any] = data(self)
        return {key: value for key, value in found.items() if (key, value) != ("scheduler", "slurm")}


def load_profile(path: Path) -> Profile:
    """Read a profile. Raises ConfigError, a line an error: the file, the field, the value and what is allowed."""
    return Profile.from_data(read_yaml(path), str(path))


def lifetime(profile: Profile, longest_unit_s: float) -> tuple[float, float]:
    """A worker's lifetime and its stagger [s]: it takes no new unit after `lifetime` +- `stagger` and ends.

    At the latest then, a unit of `longest_unit_s` and the margin still fit into the walltime. Where they do not fit
    into half of it, the lifetime is half of the walltime: a unit that is cut off is solved again, nothing else is lost.
    """
    latest = max(profile.walltime_s - longest_unit_s - profile.margin_s, profile.walltime_s / 2)
    stagger = 0.05 * latest  # so that a pool that started together does not end together
    return latest - stagger, stagger
