"""Damaged robot descriptions (URDF, SRDF): imported as `gaitflow robot import` does."""

from __future__ import annotations

import copy
import random
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from benchmarks.hostile.damage import Damage, damaged_bytes
from benchmarks.hostile.sandbox import Unsound
from benchmarks.hostile.walker import FEET, srdf, urdf
from gaitflow.config.file import ConfigError
from gaitflow.config.robot import Robot
from gaitflow.urdf.description import read_description
from gaitflow.urdf.importing import Request, import_robot
from gaitflow.urdf.mechanism import load_mechanism

REFUSALS = (ConfigError,)
URDF, SRDF = "walker.urdf", "walker.srdf"
BOX = (0.05, 0.05, 0.02)  # m
BYTES, MOVES = 60, 80  # cases at random
VALUES = {
    "missing": None, "empty": "", "text": "x", "NaN": "nan", "infinite": "inf", "negative": "-1", "zero": "0",
    "1e308": "1e308", "-1e308": "-1e308", "smallest number": "5e-324", "two numbers": "1 2", "four numbers": "1 2 3 4",
    "three huge numbers": "1e308 -1e308 1e308", "three NaN": "nan nan nan", "three zeros": "0 0 0",
    "digits joined": "1_0", "hexadecimal": "0x10", "comma": "1,5", "wide digits": "１２", "long": "1" * 100_000,
    "unprintable": "a\n\u202e\x85", "path": "../../outside/x", "another link": "base",
}  # fmt: skip
HEAD = '<?xml version="1.0"?>'
JOINT = '<link name="l{0}"/><joint name="j{0}" type="fixed"><parent link="l{0}"/><child link="l{1}"/></joint>'
WHOLE: dict[str, Callable[[str], str]] = {
    "entity": lambda text: f'<!DOCTYPE robot [<!ENTITY a "walker">]>{text.replace("walker", "&a;", 1)}',
    "entities": lambda text: (
        '<!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa">'
        + "".join(f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdefgh", "bcdefghi", strict=True))
        + f"]>{text.replace('walker', '&i;', 1)}"
    ),
    "entity of a file": lambda text: (
        '<!DOCTYPE robot [<!ENTITY a SYSTEM "../outside/secret">]>' + text.replace("</robot>", "&a;</robot>")
    ),
    "parameter entity": lambda text: f'<!DOCTYPE r [<!ENTITY % a SYSTEM "../outside/secret"> %a;]>{text}',
    "entity in odd letters": lambda text: f'<!dOcTyPe r [<!eNtItY a "b">]>{text}',
    "DOCTYPE elsewhere": lambda text: f'<!DOCTYPE robot SYSTEM "../outside/secret">{text}',
    "another encoding": lambda text: f'<?xml version="1.0" encoding="utf-7"?>{text}',
    "an encoding that is none": lambda text: f'<?xml version="1.0" encoding="no-such"?>{text}',
    "include": lambda text: text.replace(
        "</robot>", '<x:include xmlns:x="http://www.w3.org/2001/XInclude" href="../outside/secret"/></robot>'
    ),
    "namespace": lambda text: text.replace("<robot ", '<robot xmlns="http://x" '),
    "mesh elsewhere": lambda text: text.replace('<sphere radius="0.02"/>', '<mesh filename="../outside/secret"/>'),
    "character that is none": lambda text: text.replace("walker", "wal&#0;ker", 1),
    "characters": lambda text: text.replace("walker", "wal&#10;&#x202e;ker", 1),
    "comment": lambda text: text.replace("<link", "<!-- " + "x" * 100_000 + " --><link", 1),
    "a joint's mirror": lambda text: text.replace(
        "</robot>",
        '<joint name="m" type="revolute"><parent link="base"/><child link="m"/><mimic joint="m"/></joint></robot>',
    ),
    "chain": lambda text: text.replace("</robot>", "".join(JOINT.format(i, i + 1) for i in range(800)) + "</robot>"),
    "ring": lambda text: text.replace("</robot>", JOINT.format(0, 1) + JOINT.format(1, 0) + "</robot>"),
    "two roots": lambda text: text.replace("</robot>", '<link name="alone"/></robot>'),
    "nested": lambda text: text.replace("</robot>", "<a>" * 30_000 + "</a>" * 30_000 + "</robot>"),
    "attributes": lambda text: text.replace("<link ", "<link " + " ".join(f'a{i}="1" ' for i in range(90_000)), 1),
    "links": lambda text: text.replace("</robot>", "<link name='l'/>" * 60_000 + "</robot>"),
    "no links": lambda text: '<robot name="walker"/>',
    "nothing": lambda text: "",
    "two robots": lambda text: text + text,
    "no robot": lambda text: text.replace("robot", "rabbit"),
    "large": lambda text: text + " " * 5_000_000,
}


def prepare(folder: Path) -> None:
    """A sound URDF and the SRDF beside it."""
    (folder / URDF).write_text(urdf(), encoding="utf-8")
    load_mechanism(read_description(folder / URDF))  # pinocchio, once, and not in each process that imports
    (folder / SRDF).write_text(srdf(), encoding="utf-8")


def damages(sounds: Sequence[Path]) -> Iterator[tuple[int, Damage]]:
    """Every attribute of every kind of element with every odd value, whole texts, and elements and bytes at random."""
    for number, folder in enumerate(sounds):
        for name in (URDF, SRDF):
            for kind, attribute in _attributes(ElementTree.parse(folder / name).getroot()):
                for what in VALUES:
                    do = partial(_damage_attribute, name, kind, attribute, what)
                    yield number, Damage(f"attribute {what}", f"{name} {kind} {attribute}", do)
            for what in WHOLE:
                yield number, Damage(f"text {what}", name, partial(_damage_whole, name, what))
        yield from [(number, Damage("bytes", "", _damage_bytes))] * BYTES
        yield from [(number, Damage("element", "", _damage_element))] * MOVES


def ask(folder: Path) -> Any:
    """The robot that is made of it. Raises ConfigError, Unsound."""
    imported = import_robot(Request(folder / URDF, "walker", FEET, box=BOX))
    data = imported.robot.as_data()
    if Robot.from_data(data, "again") != imported.robot:
        raise Unsound("the robot is another one once it was written and read")
    if any(not sentence.isprintable() for sentence in imported.found):
        raise Unsound("what was found is no clear line")
    return {name: each for name, each in data.items() if name != "source"}


def _attributes(root: Element) -> list[tuple[str, str]]:
    """The kinds of elements, "joint/axis", with the attributes that they have."""
    found = {("robot", name): None for name in root.attrib}
    for parent in root.iter():
        for each in parent:
            found |= {(f"{parent.tag}/{each.tag}", name): None for name in each.attrib}
    return list(found)


def _damage_attribute(
    name: str, kind: str, attribute: str, what: str, folder: Path, outside: Path, chance: random.Random
) -> str:
    """Of one element of a kind, or of all."""
    tree = ElementTree.parse(folder / name)
    parent, _, tag = kind.rpartition("/")
    root = tree.getroot()
    alike = [root] if not parent else [each for holder in root.iter(parent) for each in holder.findall(tag)]
    chosen = [each for each in alike if attribute in each.attrib]
    for each in chosen if chance.random() < 0.3 else [chance.choice(chosen)]:
        value = VALUES[what]
        if value is None:
            del each.attrib[attribute]
        else:
            each.set(attribute, value)
    tree.write(folder / name, encoding="utf-8")
    return ""


def _damage_whole(name: str, what: str, folder: Path, outside: Path, chance: random.Random) -> str:
    (outside / "secret").write_text("<link name='secret'/>", encoding="utf-8")
    (folder / name).write_text(WHOLE[what]((folder / name).read_text(encoding="utf-8")), encoding="utf-8")
    return ""


def _damage_bytes(folder: Path, outside: Path, chance: random.Random) -> str:
    path = folder / chance.choice([URDF, URDF, SRDF])
    how, content = damaged_bytes(path.read_bytes(), chance)
    path.write_bytes(content)
    return how


def _damage_element(folder: Path, outside: Path, chance: random.Random) -> str:
    """An element that is missing, there twice, elsewhere, of another kind, or a joint of another type."""
    path = folder / chance.choice([URDF, URDF, URDF, SRDF])
    tree = ElementTree.parse(path)
    pairs = [(parent, each) for parent in tree.getroot().iter() for each in parent]
    parent, element = chance.choice(pairs)
    how = chance.choice(["missing", "twice", "moved", "renamed", "type", "scaled", "text"])
    match how:
        case "missing":
            parent.remove(element)
        case "twice":
            parent.append(copy.deepcopy(element))
        case "moved":
            parent.remove(element)
            chance.choice([each for each, _ in pairs if each not in set(element.iter())]).append(element)
        case "renamed":
            element.tag = chance.choice(["link", "joint", "inertial", "x", "{http://x}link"])
        case "type":
            kinds = ["continuous", "prismatic", "floating", "planar", "spherical", "fixed", "x", ""]
            chance.choice(tree.getroot().findall("joint") or [element]).set("type", chance.choice(kinds))
        case "scaled":
            factor = chance.choice([1e-300, 1e-12, 1e-3, 1e3, 1e12, 1e150, 1e300])
            for each in tree.getroot().iter(element.tag):
                each.attrib.update({name: _scaled(text, factor) for name, text in each.attrib.items()})
        case _:
            element.text = chance.choice(["x", "\u202e", "1e308" * 1000])
    tree.write(path, encoding="utf-8")
    return how


def _scaled(text: str, factor: float) -> str:
    try:
        with np.errstate(over="ignore"):
            return " ".join(str(float(word) * factor) for word in text.split())
    except ValueError:
        return text
