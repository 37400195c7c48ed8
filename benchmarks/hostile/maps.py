"""Damaged maps, their digests made right again: loaded, asked, exported, and planned with."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any

import casadi  # noqa: F401  # once, and not in each process that plans
import numpy as np

from benchmarks.hostile import fields, folders, graphs, tensors
from benchmarks.hostile.damage import Damage, damaged_bytes
from benchmarks.hostile.map_bin import exported
from benchmarks.hostile.remade import remade
from benchmarks.hostile.sandbox import Unsound
from gaitflow.core.errors import ArtifactError, OutOfDomain
from gaitflow.export.graph import CannotExport
from gaitflow.runtime import GaitMap
from gaitflow.runtime.files import ATLAS, CLASSIFIER, MANIFEST, PROBLEM_CHECK, WARM_STARTS, entry_of
from gaitflow.runtime.manifest import FORMAT, SELF_DIGEST
from gaitflow.runtime.plan import Plan
from gaitflow.runtime.tensors import WarmStart

REFUSALS = (ArtifactError,)
PLACES = (0.0, 0.1, 0.23, 0.37, 0.5, 0.66, 0.82)  # parts of the way along all axes
GRAPHS = 80  # cases a map
REMADE = 20  # cases a map whose problem is another one, and proved to be
PLANNED = (0.23, 0.5, 0.82)
FREE = ("metrics", "code")  # of a manifest, whose fields no reader knows
TENSORS = (WARM_STARTS, ATLAS, PROBLEM_CHECK)


def damages(sounds: Sequence[Path]) -> Iterator[tuple[int, Damage]]:
    """The number of a sound map with what to do to a copy of it: every field in every way, and much at random."""
    known: set[tuple[str, str]] = set()
    for number, folder in enumerate(sounds):
        found = [*_of_manifest(folder), *(each for name in TENSORS for each in _of_header(folder, name))]
        yield from ((number, each) for each in found if (each.what, each.place) not in known)
        known |= {(each.what, each.place) for each in found}
        yield from [(number, Damage(f"{CLASSIFIER} graph", "", _damage_graph))] * GRAPHS
        if _dimension(folder) == 3:  # a motion in space takes as long as ten in the plane
            continue
        for what, (times, do) in _AT_RANDOM.items():
            yield from [(number, Damage(what, "", do))] * times
        if (folder / PROBLEM_CHECK).exists():  # older maps have their problem as code
            yield from [(number, Damage("numbers of the problem", "", _damage_meaning))] * REMADE


def ask(folder: Path) -> Any:
    """What the map says of a few tasks, in all ways that it may be asked. Raises ArtifactError, Unsound."""
    gait_map = GaitMap.load(folder)
    axes = gait_map.manifest.domain.axes
    tasks = [{axis: each[0] + part * (each[-1] - each[0]) for axis, each in axes.items()} for part in PLACES]
    said: list[Any] = [_selected(gait_map, task) for task in tasks]
    many = gait_map.select_many(**{axis: np.array([task[axis] for task in tasks]) for axis in axes})
    if not np.isfinite(many.probability).all() or list(many.gaits) != [each[0] for each in said]:
        raise Unsound("the tasks together have other answers than one by one")
    for gait in gait_map.gaits:
        _check(gait_map.mean_start(gait.name, 0.6))
    if gait_map.manifest.format < FORMAT:
        return said  # it plans by code that nobody trusts
    try:
        said.append(len(exported(folder)))
    except CannotExport as error:
        said.append(str(error))
    return [*said, *(_planned(gait_map, task) for part, task in zip(PLACES, tasks, strict=True) if part in PLANNED)]


def _selected(gait_map: GaitMap, task: dict[str, Any]) -> list[Any]:
    choice = gait_map.select(**task)
    start = None if choice.gait is None else choice.warm_start
    if start is not None:
        _check(start)
        if not 0 <= choice.probability <= 1.001 or choice.gait not in [gait.name for gait in gait_map.gaits]:
            raise Unsound(f"{choice.gait} with the probability {choice.probability}")
    length = None if start is None else float(np.abs(start.primal).sum())
    return [choice.gait, choice.pattern, choice.in_domain, choice.probability, length]


def _planned(gait_map: GaitMap, task: dict[str, Any]) -> list[Any]:
    try:
        plan = gait_map.plan(**task)
    except OutOfDomain:
        return ["out of the domain"]
    if plan.feasible and not _finite(plan):
        raise Unsound(f"a plan of the cost {plan.cost} is feasible and not finite")
    return [plan.gait, plan.pattern, plan.feasible, f"{plan.cost:.4g}"]


def _finite(plan: Plan) -> bool:
    motion = (plan.times, plan.base, plan.feet, plan.forces, plan.foot_velocities, plan.durations)
    return np.isfinite(plan.cost) and all(bool(np.isfinite(each).all()) for each in motion)


def _check(start: WarmStart) -> None:
    vectors = (start.primal, start.multipliers_bounds, start.multipliers_rows, start.base, start.forces)
    if not all(np.isfinite(each).all() for each in vectors):
        raise Unsound(f"the start of {start.gait} is not finite")


def _of_manifest(folder: Path) -> Iterator[Damage]:
    data = json.loads((folder / MANIFEST).read_bytes())
    for path in fields.fields_of(data):
        if path[0] == SELF_DIGEST or (path[0] in FREE and len(path) > 1):
            continue
        for oddity in fields.oddities_of(data, path):
            yield Damage(f"{MANIFEST} {oddity}", ".".join(map(str, path)), partial(_damage_manifest, path, oddity))


def _of_header(folder: Path, name: str) -> Iterator[Damage]:
    if (folder / name).exists():
        for path, oddity in tensors.header_fields((folder / name).read_bytes()):
            place = ".".join([tensors.kind_of(str(path[0])), *map(str, path[1:])])
            yield Damage(f"{name} header {oddity}", place, partial(_damage_header, name, path, oddity))


def _damage_manifest(path: fields.Path, oddity: str, folder: Path, outside: Path, chance: random.Random) -> str:
    data = json.loads((folder / MANIFEST).read_bytes())
    (folder / MANIFEST).write_bytes(_encoded(fields.damaged_field(data, path, oddity)))
    return ""


def _damage_header(
    name: str, path: fields.Path, oddity: str, folder: Path, outside: Path, chance: random.Random
) -> str:
    _replace(folder, {name: tensors.with_header((folder / name).read_bytes(), path, oddity)})
    return ""


def _damage_tensors(folder: Path, outside: Path, chance: random.Random) -> str:
    name = chance.choice([each for each in TENSORS if (folder / each).exists()])
    how, content = tensors.damaged((folder / name).read_bytes(), chance)
    _replace(folder, {name: content})
    return f"{name} {how}"


def _damage_graph(folder: Path, outside: Path, chance: random.Random) -> str:
    how, content = graphs.damaged((folder / CLASSIFIER).read_bytes(), outside, chance)
    _replace(folder, {CLASSIFIER: content})
    return how


def _damage_bytes(folder: Path, outside: Path, chance: random.Random) -> str:
    """Anywhere, or in the first bytes, where files say what they are."""
    name = chance.choice([path.name for path in sorted(folder.iterdir()) if path.name != MANIFEST])
    content, head = (folder / name).read_bytes(), chance.choice([64, 4096, 1 << 30])
    how, damaged = damaged_bytes(content[:head], chance)
    _replace(folder, {name: damaged + content[head:]})
    return f"{name} {how}"


def _damage_folder(folder: Path, outside: Path, chance: random.Random) -> str:
    files = sorted(folder.iterdir())
    how = folders.damaged(chance.choice(files), files, outside, chance)
    kept = [path for path in files if path.is_file() and not path.is_symlink() and path.stat().st_size < 1 << 30]
    if chance.random() < 0.7 and folder / MANIFEST in kept:
        try:
            _replace(folder, {path.name: path.read_bytes() for path in kept if path.name != MANIFEST})
        except ValueError:  # it is the manifest that was damaged
            return how
    return how


def _damage_meaning(folder: Path, outside: Path, chance: random.Random) -> str:
    manifest = json.loads((folder / MANIFEST).read_bytes())
    changed, check = remade(manifest, chance)
    (folder / MANIFEST).write_bytes(_encoded(changed))
    _replace(folder, {PROBLEM_CHECK: check})
    return ""


_AT_RANDOM: dict[str, tuple[int, Callable[[Path, Path, random.Random], str]]] = {
    "tensors": (70, _damage_tensors),
    "bytes": (50, _damage_bytes),
    "file": (40, _damage_folder),
}


def _dimension(folder: Path) -> int:
    robot = json.loads((folder / MANIFEST).read_bytes())["scenario"]["robot"]
    return int(robot["dimension"])


def _replace(folder: Path, contents: dict[str, bytes]) -> None:
    """Write files, and make their entries in the manifest right again."""
    manifest = json.loads((folder / MANIFEST).read_bytes())
    for name, content in contents.items():
        (folder / name).write_bytes(content)
        if name in manifest["files"]:
            manifest["files"][name] = asdict(entry_of(content))
    (folder / MANIFEST).write_bytes(_encoded(manifest))


def _encoded(manifest: Any) -> bytes:
    """As `manifest.encode` writes it, and whatever JSON can hold besides."""
    if not isinstance(manifest, dict):
        return json.dumps(manifest).encode()
    rest = {key: value for key, value in manifest.items() if key != SELF_DIGEST}
    text = (json.dumps(rest, sort_keys=True, indent=1) + "\n").encode()
    return (json.dumps(rest | {SELF_DIGEST: sha256(text).hexdigest()}, sort_keys=True, indent=1) + "\n").encode()
