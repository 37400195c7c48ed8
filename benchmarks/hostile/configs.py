"""Damaged scenarios, robots and cluster profiles: read, and written out as the data they are."""

from __future__ import annotations

import random
import shutil
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import yaml

from benchmarks.hostile import fields
from benchmarks.hostile.damage import Damage, damaged_bytes
from benchmarks.hostile.sandbox import Unsound
from gaitflow.config.cluster import Profile, load_profile
from gaitflow.config.file import ConfigError
from gaitflow.config.robot import Robot, load_robot
from gaitflow.config.scenario import Scenario, digest_of, load_scenario

REFUSALS = (ConfigError,)
SCENARIO, PLANAR, SPATIAL, PROFILE = "scenario.yaml", "half_cheetah.yaml", "go1.yaml", "profile.yaml"
NAMES = (SCENARIO, PLANAR, SPATIAL, PROFILE)
BYTES = 150  # cases of damaged bytes
TEXTS = {
    "aliases": "a: &x [1,1,1,1,1,1,1,1,1]\n" + "".join(f"b{i}: &y{i} [*x,*x,*x,*x,*x,*x]\n" for i in range(9)),
    "nested lists": "[" * 20_000,
    "nested mappings": "{a: " * 20_000,
    "nested blocks": "- " * 40_000,
    "python object": "!!python/object/apply:os.system [touch never]",
    "python name": "name: !!python/name:os.system",
    "binary": "a: !!binary abcd",
    "merge": "<<: [{name: x}, {name: y}]\nmass: 1",
    "list as a name": "? [a, b]\n: c",
    "byte order marks": "\ufeff\ufeffname: x",
    "digits": "mass: " + "1" * 10_000,
    "hexadecimal": "mass: 0x" + "f" * 90_000,
    "base 60": "mass: " + ":".join(["1"] * 40_000),
    "fraction in base 60": "mass: " + ":".join(["1"] * 300) + ".5",
    "a long list": "legs: [" + "1," * 49_000 + "1]",
    "a long block": "legs:\n" + "- 1\n" * 24_000,
    "many fields": "".join(f"k{i}: 1\n" for i in range(10_000)),
    "too large": "name: " + "x" * 2_000_000,
    "twice": "name: x\nname: y",
    "nothing": "",
    "documents": "---\na: 1\n---\nb: 2",
    "another YAML": "%YAML 9.9\n---\na: 1\n",
    "escapes": '"\\e[31m\\n": 1',
    "half a letter": 'name: "\\ud800"',
    "infinite": "mass: 1.0e+999",
    "no number": "mass: .nan",
}


def prepare(checkout: Path, folder: Path) -> None:
    """A sound file of each kind."""
    shutil.copyfile(checkout / "configs/scenarios/quickstart.yaml", folder / SCENARIO)
    for name in (PLANAR, SPATIAL):
        shutil.copyfile(checkout / "configs/robots" / name, folder / name)
    shutil.copyfile(checkout / "slurm/profiles/test-cluster.yaml", folder / PROFILE)


def damages(sounds: Sequence[Path]) -> Iterator[tuple[int, Damage]]:
    """Every field of every file in every way, texts that are no such file, and bytes at random."""
    for number, folder in enumerate(sounds):
        for name in NAMES:
            data = yaml.safe_load((folder / name).read_text(encoding="utf-8"))
            for path in fields.fields_of(data):
                for oddity in fields.oddities_of(data, path):
                    place = f"{name} {'.'.join(map(str, path))}"
                    yield number, Damage(f"field {oddity}", place, partial(_damage_field, name, path, oddity))
        yield from ((number, Damage(f"text {what}", "", partial(_damage_text, text))) for what, text in TEXTS.items())
        yield from [(number, Damage("bytes", "", _damage_bytes))] * BYTES


def ask(folder: Path) -> Any:
    """What the files say, and whether they still say it once written and read again. Raises ConfigError, Unsound."""
    scenario = load_scenario(folder / SCENARIO, robots=folder)
    read: list[tuple[type[Any], Any]] = [
        (Scenario, scenario), (Robot, load_robot(folder / PLANAR)), (Robot, load_robot(folder / SPATIAL)),
        (Profile, load_profile(folder / PROFILE)),
    ]  # fmt: skip
    for model, each in read:
        if model.from_data(each.as_data(), "again") != each:
            raise Unsound(f"{model.__name__} is another one once it was written and read")
    return [digest_of(each.as_data()) for _, each in read]


def _damage_field(name: str, path: fields.Path, oddity: str, folder: Path, outside: Path, chance: random.Random) -> str:
    data = yaml.safe_load((folder / name).read_text(encoding="utf-8"))
    text = yaml.safe_dump(fields.damaged_field(data, path, oddity), allow_unicode=True)
    (folder / name).write_text(text, encoding="utf-8")
    return ""


def _damage_text(text: str, folder: Path, outside: Path, chance: random.Random) -> str:
    (folder / chance.choice(NAMES)).write_text(text, encoding="utf-8")
    return ""


def _damage_bytes(folder: Path, outside: Path, chance: random.Random) -> str:
    path = folder / chance.choice(NAMES)
    how, content = damaged_bytes(path.read_bytes(), chance)
    path.write_bytes(content)
    return how
