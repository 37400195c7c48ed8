"""Damaged scenarios, robots, cluster profiles and robot descriptions: read, and written out as the data they are."""

from __future__ import annotations

import random
import shutil
from pathlib import Path
from typing import Any

import yaml

from benchmarks.hostile.damage import damaged_bytes, damaged_data
from benchmarks.hostile.sandbox import Unsound
from gaitflow.config.cluster import Profile, load_profile
from gaitflow.config.file import ConfigError
from gaitflow.config.robot import Robot, load_robot
from gaitflow.config.scenario import Scenario, digest_of, load_scenario
from gaitflow.urdf.description import read_description

REFUSALS = (ConfigError,)
SCENARIO, ROBOT, PROFILE, DESCRIPTION = "scenario.yaml", "half_cheetah.yaml", "profile.yaml", "robot.urdf"
TEXTS = (
    "a: &x [1,1,1,1,1,1,1,1,1]\n" + "".join(f"b{i}: &y{i} [*x,*x,*x,*x,*x,*x]\n" for i in range(9)),
    "[" * 20_000,
    "{a: " * 20_000,
    "!!python/object/apply:os.system [touch /tmp/never]",
    "a: !!binary abcd",
    "? [a, b]\n: c",
    "\ufeff\ufeffname: x",
    "1" * 10_000,
    "name: x\nname: y",
    "",
    "---\na: 1\n---\nb: 2",
)
JOINT = '<link name="l{0}"/><joint name="j{0}" type="fixed"><parent link="l{0}"/><child link="l{1}"/></joint>'
LINKS = (
    "".join(JOINT.format(i, i + 1) for i in range(800)),
    "<a>" * 30_000 + "</a>" * 30_000,
    "<link " + " ".join(f'a{i}="1"' for i in range(200_000)) + "/>",
    "<link name='l'/>" * 60_000,
)


def prepare(checkout: Path, folder: Path) -> None:
    """A sound file of each kind."""
    shutil.copyfile(checkout / "configs/scenarios/quickstart.yaml", folder / SCENARIO)
    shutil.copyfile(checkout / "configs/robots/half_cheetah.yaml", folder / ROBOT)
    shutil.copyfile(checkout / "slurm/profiles/test-cluster.yaml", folder / PROFILE)
    inertia = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
    links = "".join(
        f'<link name="l{i}"><inertial><mass value="1"/>{inertia}</inertial></link>'
        f'<joint name="j{i}" type="revolute"><parent link="b"/><child link="l{i}"/><axis xyz="0 1 0"/></joint>'
        for i in range(4)
    )
    (folder / DESCRIPTION).write_text(f'<robot name="a"><link name="b"/>{links}</robot>', encoding="utf-8")


def damage(folder: Path, outside: Path, chance: random.Random) -> str:
    """Damage one of the files in a folder; what was done."""
    name = chance.choice([SCENARIO, SCENARIO, ROBOT, PROFILE, DESCRIPTION])
    path = folder / name
    what = chance.choice(["bytes", "text"] if name == DESCRIPTION else ["data", "data", "data", "bytes", "text"])
    if what == "data":
        how, data = damaged_data(yaml.safe_load(path.read_text(encoding="utf-8")), chance)
        try:
            path.write_text(yaml.safe_dump(data, allow_unicode=True), encoding="utf-8")
        except (RecursionError, UnicodeEncodeError):  # of PyYAML's writer
            path.write_text("a: " * 1000, encoding="utf-8")
        what = f"data {how}"
    elif what == "bytes":
        how, content = damaged_bytes(path.read_bytes(), chance)
        path.write_bytes(content)
        what = f"bytes {how}"
    elif name == DESCRIPTION:
        path.write_text(f'<robot name="a">{chance.choice(LINKS)}</robot>', encoding="utf-8")
    else:
        path.write_text(chance.choice(TEXTS), encoding="utf-8")
    return f"{name} {what}"


def ask(folder: Path, number: int) -> Any:
    """What the files say, and whether they still say it once written and read again. Raises ConfigError, Unsound."""
    scenario = load_scenario(folder / SCENARIO, robots=folder)
    read: list[tuple[type[Any], Any]] = [
        (Scenario, scenario), (Robot, load_robot(folder / ROBOT)), (Profile, load_profile(folder / PROFILE))
    ]  # fmt: skip
    for model, each in read:
        if model.from_data(each.as_data(), "again") != each:
            raise Unsound(f"{model.__name__} is another one once it was written and read")
    description = read_description(folder / DESCRIPTION)
    return [*(digest_of(each.as_data()) for _, each in read), description.name, description.mass]
