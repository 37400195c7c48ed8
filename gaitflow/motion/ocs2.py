"""Contacts for OCS2's legged robots, in the syntax of their `gait.info` and `reference.info`."""

from __future__ import annotations

import re
from collections.abc import Sequence

from gaitflow.core.names import quadruped_places
from gaitflow.motion.contact_schedule import Interval, Span, intervals, written
from gaitflow.motion.journey import Journey
from gaitflow.motion.motion import Motion

LEGS = ("LF", "RF", "LH", "RH")  # in the order of OCS2's names of modes


def gait_info(motion: Motion | Journey, name: str) -> str:
    """One cycle as a block of `gait.info`, under `name` with what is no letter or digit replaced by "_".

    A mode is called after the legs that stand. The block needs a line of its own in the file's `list`. Raises
    ValueError for legs that are not called as a quadruped's are, and for a journey, which no template repeats.
    """
    if isinstance(motion, Journey):
        raise ValueError("a journey has no cycle that a template could repeat: ask for mode_schedule(journey, span)")
    found = intervals(motion)
    return _block(name, _modes(motion, found), "switchingTimes", [0.0, *(each.end for each in found)])


def mode_schedule(motion: Motion | Journey, span: Span, name: str = "initialModeSchedule") -> str:
    """A span (start, stop) [s] as a block of OCS2's `ModeSchedule`, as `loadModeSchedule` reads it from a file.

    Event times are the motion's own; the first and the last mode go on before and after them. Raises ValueError as
    `gait_info`, and for a span that does not go from one time to a later one.
    """
    found = intervals(motion, span=span)
    return _block(name, _modes(motion, found), "eventTimes", [each.end for each in found[:-1]])


def _modes(motion: Motion | Journey, found: Sequence[Interval]) -> list[str]:
    places = quadruped_places(motion.leg_names)
    if places is None:
        raise ValueError(
            f"legs {', '.join(motion.leg_names)}: OCS2's modes are those of a quadruped, whose legs are called "
            f"{', '.join(LEGS)}, or FL, FR, RL, RR"
        )
    return [_mode([each.contact[place] for place in places]) for each in found]


def _block(name: str, modes: Sequence[str], label: str, times: Sequence[float]) -> str:
    lines = [
        re.sub(r"\W+", "_", name).strip("_"),
        "{",
        "  modeSequence",
        "  {",
        *(f"    [{number}]     {mode}" for number, mode in enumerate(modes)),
        "  }",
        f"  {label}",
        "  {",
        *(f"    [{number}]     {written(time)}" for number, time in enumerate(times)),
        "  }",
        "}",
    ]
    return "\n".join(lines) + "\n"


def _mode(contact: list[bool]) -> str:
    if all(contact):
        return "STANCE"
    return "_".join(leg for leg, stands in zip(LEGS, contact, strict=True) if stands) or "FLY"
