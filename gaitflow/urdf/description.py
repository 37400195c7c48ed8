"""Robot descriptions (URDF, SRDF) as checked text: a size limit, no entities, a sane number of links, no other file."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from reprlib import repr as short
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from gaitflow.config.file import ConfigError, read_bytes

Array = NDArray[np.float64]

MAX_BYTES = 4_000_000
MAX_ELEMENTS = 50_000
MAX_LINKS = 1_000  # a legged robot has some dozens
MAX_CHAIN = 100  # links one below the other: the library that reads it walks the tree recursively
MAX_NESTING = 20  # elements one inside the other
MAX_NAME = 200  # letters, all printable: errors and results show names
MAX_ATTRIBUTES = 100  # of one element: the time that the library takes grows with their square
NEGLIGIBLE = 0.01  # of all links' moments: makers give cameras and empty base links placeholders that no body has
MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
INSTALLED = ("share", "site-packages")  # folders below which a path is the same on every machine


@dataclass(frozen=True)
class Description:
    """One URDF or SRDF file: its text, the robot's name and its links' mass [kg]. What it refers to is never opened."""

    path: Path
    name: str
    text: str
    mass: float

    @property
    def label(self) -> str:
        """What a result may call it."""
        return label_of(self.path)


def label_of(path: Path) -> str:
    """A path from where packages are installed on, or the file's name alone: the same on every machine."""
    parts = path.absolute().parts
    below = [index + 1 for index, part in enumerate(parts[:-1]) if part in INSTALLED]
    return "/".join(parts[below[-1] :]) if below else path.name


def read_description(path: Path) -> Description:
    """Read a URDF or SRDF. Raises ConfigError: not readable, too large, not XML of a <robot>, or with a DOCTYPE."""
    try:
        text = read_bytes(path, MAX_BYTES, "a robot description").decode()
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: not UTF-8 text ({error.reason} at byte {error.start})") from None
    if re.search(r"<!\s*(DOCTYPE|ENTITY)", text, re.IGNORECASE):
        raise ConfigError(f"{path}: has a DOCTYPE or ENTITY, which a robot description does not need: remove it")
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise ConfigError(f"{path}: not valid XML ({error}); a .xacro must be expanded to a URDF first") from None
    name = root.get("name")
    if root.tag != "robot" or not name:
        raise ConfigError(f"{path}: expected <robot name=...>, found <{root.tag[:40]}>")
    elements, links = sum(1 for _ in root.iter()), len(root.findall("link"))
    if elements > MAX_ELEMENTS or links > MAX_LINKS:
        raise ConfigError(
            f"{path}: {elements} elements, {links} links; the most it may have are {MAX_ELEMENTS} and {MAX_LINKS}"
        )
    found = {
        "attributes in one element": (max(len(each.attrib) for each in root.iter()), MAX_ATTRIBUTES),
        "elements one inside the other": (_nesting(root), MAX_NESTING),
        "links one below the other": (_longest_chain(root), MAX_CHAIN),
    }
    for what, (count, most) in found.items():
        if count > most:
            raise ConfigError(f"{path}: has {count} or more {what}; the most it may have are {most}")
    for each in root.iter():
        own = each.get("name", "")
        if len(own) > MAX_NAME or not own.isprintable():
            raise ConfigError(f"{path}: the name {short(own)}: must have at most {MAX_NAME} letters, all printable")
    bodies = {link.get("name"): _body(path, link) for link in root.iterfind("link[inertial]")}
    _check_moments(path, {link: inertia for link, (_, inertia) in bodies.items()})
    return Description(path, name, text, sum(mass for mass, _ in bodies.values()))


def _nesting(root: ElementTree.Element) -> int:
    """How many elements are one inside the other; counted up to one more than there may be."""
    level, depth = [root], 0
    while level and depth <= MAX_NESTING:
        level, depth = [child for each in level for child in each], depth + 1
    return depth


def _longest_chain(root: ElementTree.Element) -> int:
    """How many links hang one below the other at the most; more than there are joints, where they form a ring."""
    joints = [(joint.find("parent"), joint.find("child")) for joint in root.iterfind("joint")]
    ends = [(a.get("link"), b.get("link")) for a, b in joints if a is not None and b is not None]
    depths: dict[str | None, int] = {child: 1 for _, child in ends}
    for _ in range(MAX_CHAIN + 1):
        deeper = {child: max(depths[child], depths.get(parent, 0) + 1) for parent, child in ends}
        if deeper == depths:
            break
        depths = deeper
    return max(depths.values(), default=0)


def _body(path: Path, link: ElementTree.Element) -> tuple[float, Array]:
    """Mass [kg] and inertia [3, 3] kg m^2 of a link, whose numbers must all be numbers: urdfdom would go on without."""
    stated = {"mass": ("value",), "inertia": MOMENTS}
    texts: dict[str, str] = {}
    for part, keys in stated.items():
        element = link.find(f"inertial/{part}")
        texts |= {f"{part} {key}": "" if element is None else element.get(key, "") for key in keys}
    for what, text in texts.items():
        if not math.isfinite(_number(text)) or float(texts["mass value"]) < 0:
            raise ConfigError(
                f"{path}: link {link.get('name')!r} has {what} = {text[:40]!r}: must be a number, mass >= 0"
            )
    xx, xy, xz, yy, yz, zz = (float(texts[f"inertia {key}"]) for key in MOMENTS)
    return float(texts["mass value"]), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _check_moments(path: Path, inertias: Mapping[str | None, Array]) -> None:
    """Raises ConfigError for a link whose inertia no body has, unless what is wrong is too little to matter."""
    moments = {link: np.linalg.eigvalsh(inertia) for link, inertia in inertias.items()}
    total = sum(float(np.abs(own).max()) for own in moments.values())
    for link, own in moments.items():
        if own[2] - own[1] - own[0] > NEGLIGIBLE * total:  # of a negative moment, too: own is sorted
            raise ConfigError(
                f"{path}: link {link!r} has an inertia with the principal moments "
                f"{' and '.join(f'{moment:.4g}' for moment in own)} kg m^2; of a body none is negative or larger than "
                "the sum of the other two"
            )


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
