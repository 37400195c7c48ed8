"""The pose a robot stands in: named in its SRDF, or joint values given by hand."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from gaitflow.config.file import ConfigError
from gaitflow.urdf.description import Description, read_description
from gaitflow.urdf.mechanism import Array, Mechanism

STANDING = ("standing", "half_sitting")  # names of group_states that are tried when no pose is asked for
MAX_NEIGHBOURS = 50  # SRDF files looked at
MOST_SAID = 24  # names in one error


@dataclass(frozen=True)
class Pose:
    """Joint angles [joints] rad and where they come from."""

    angles: Array
    label: str


def is_written(asked: str | None) -> bool:
    """Whether a pose that is asked for gives the joints' values itself, so that no SRDF is needed."""
    return asked is not None and "=" in asked


def find_srdf(urdf: Description) -> Description | None:
    """The SRDF of the same robot beside a URDF or in `../srdf`; of several, the one whose file has the URDF's name.

    Raises ConfigError when several fit equally.
    """
    folder = urdf.path.absolute().parent
    files = [*sorted(folder.glob("*.srdf")), *sorted((folder.parent / "srdf").glob("*.srdf"))][:MAX_NEIGHBOURS]
    found = [srdf for srdf in map(read_description, files) if srdf.name == urdf.name]
    named = [srdf for srdf in found if srdf.path.stem == urdf.path.stem]
    found = named or found
    if len(found) > 1:
        raise ConfigError(f"{urdf.path}: {', '.join(srdf.path.name for srdf in found)} all fit: choose with --srdf")
    return found[0] if found else None


def pose_of(asked: str | None, mechanism: Mechanism, leg_joints: Sequence[int], srdf: Description | None) -> Pose:
    """The pose that `asked` names (a group_state of the SRDF) or writes out (`J=V,...`); None: the standing one.

    Joints of the legs must have a value; the others stay at zero, or at the limit next to it.
    Raises ConfigError: no such pose, unknown joints, legs without values, values beyond the joint's limits.
    """
    if asked is not None and is_written(asked):
        values, label = _written(asked), f"pose {asked}"
    else:
        states = {} if srdf is None else _group_states(srdf)
        name = asked or next((name for name in STANDING if name in states), None)
        if name not in states:
            known = (
                f"{srdf.label} has {', '.join(list(states)[:MOST_SAID]) or 'none'}"
                if srdf
                else "no SRDF of this robot was found"
            )
            raise ConfigError(
                f"{mechanism.label}: {f'no pose {asked!r}' if asked else 'which pose?'} ({known}): name one with "
                "--pose and --srdf, or give every leg joint a value: --pose JOINT=RAD,JOINT=RAD,..."
            )
        values, label = states[name], f"pose {name}"
    return Pose(_angles(values, mechanism, leg_joints, label), label)


def _angles(values: Mapping[str, float], mechanism: Mechanism, leg_joints: Sequence[int], label: str) -> Array:
    names, where = mechanism.joint_names, f"{mechanism.label}: {label}"
    unknown = [name for name in values if name not in names]
    if unknown:
        raise ConfigError(
            f"{where}: no joint {', '.join(unknown[:MOST_SAID])}; joints are {', '.join(names[:MOST_SAID])}"
        )
    missing = [names[joint] for joint in leg_joints if names[joint] not in values]
    if missing:
        raise ConfigError(f"{where}: no value for the leg joints {', '.join(missing[:MOST_SAID])}")
    angles = np.clip(np.zeros(len(names)), mechanism.lower, mechanism.upper)
    for name, value in values.items():
        joint = names.index(name)
        low, high = mechanism.lower[joint], mechanism.upper[joint]
        if not low <= value <= high:
            raise ConfigError(f"{where}: {name} = {value:g} is beyond the joint's limits, {low:g} to {high:g}")
        angles[joint] = value
    return angles


def _written(text: str) -> dict[str, float]:
    values: dict[str, float] = {}
    for part in text.split(","):
        name, _, number = part.partition("=")
        value = _number(number)
        if not name.strip() or value is None or name.strip() in values:
            raise ConfigError(f"--pose: {part!r} is not JOINT=RAD, or the joint is given twice")
        values[name.strip()] = value
    return values


def _group_states(srdf: Description) -> dict[str, dict[str, float]]:
    """Poses by name; values of joints with one degree of freedom (the floating base has seven numbers)."""
    states: dict[str, dict[str, float]] = {}
    for state in ElementTree.fromstring(srdf.text).findall("group_state"):
        values = states.setdefault(state.get("name", ""), {})
        for joint in state.findall("joint"):
            text = joint.get("value", "")
            if len(text.split()) != 1:
                continue
            value = _number(text)
            if value is None:
                raise ConfigError(f"{srdf.path}: joint {joint.get('name')!r} has value {text[:40]!r}, not a number")
            values[joint.get("name", "")] = value
    return states


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None
