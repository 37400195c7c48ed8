"""A gait for OCS2's legged robots: a mode sequence template in the syntax of their `gait.info`."""

from __future__ import annotations

import re

from gaitflow.core.names import quadruped_places
from gaitflow.motion.contact_schedule import intervals, written
from gaitflow.motion.motion import Motion

LEGS = ("LF", "RF", "LH", "RH")  # in the order of OCS2's names of modes


def gait_info(motion: Motion, name: str) -> str:
    """One cycle as a block of `gait.info`, under `name` with what is no letter or digit replaced by "_".

    A mode is called after the legs that stand. The block needs a line of its own in the file's `list`. Raises
    ValueError for legs that are not called as a quadruped's are.
    """
    places = quadruped_places(motion.leg_names)
    if places is None:
        raise ValueError(
            f"legs {', '.join(motion.leg_names)}: OCS2's modes are those of a quadruped, whose legs are called "
            f"{', '.join(LEGS)}, or FL, FR, RL, RR"
        )
    found = intervals(motion)
    modes = [_mode([each.contact[place] for place in places]) for each in found]
    times = [0.0, *(each.end for each in found)]
    lines = [
        re.sub(r"\W+", "_", name).strip("_"),
        "{",
        "  modeSequence",
        "  {",
        *(f"    [{number}]     {mode}" for number, mode in enumerate(modes)),
        "  }",
        "  switchingTimes",
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
