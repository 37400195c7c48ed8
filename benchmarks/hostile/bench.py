"""Thousands of damaged files, each read in a process of its own: what comes of them."""

from __future__ import annotations

import os
import random
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from benchmarks.document import document
from benchmarks.hostile import configs, datasets, map_bin, maps, urdfs
from benchmarks.hostile.damage import Damage
from benchmarks.hostile.sandbox import CPU_S, GOOD, Outcome, ask
from benchmarks.rows import Row

# Of all the damages that a kind of file may have, the most that are tried.
CASES = {"maps": 1200, "configs": 600, "datasets": 500, "urdfs": 450, "map_bin": 500}
PLANNING_CPU_S = 90  # of three motions that there are not, each sought by all gaits and by IPOPT
MODULES: dict[str, ModuleType] = {"maps": maps, "configs": configs, "datasets": datasets, "urdfs": urdfs}
MODELS = (
    "half-cheetah-exact-vibration/1.1.0",  # of layers
    "half-cheetah-exact-effort/1.1.0",  # support vectors
    "half-cheetah-exact-slope20-vibration/1.1.0",  # neighbours
    "go1-energy/1.0.0",  # trees
)
OLDER = ("half-cheetah-flat-vibration/1.0.0", "half-cheetah-flat-vibration/1.1.0")  # of formats 1 and 2
DATASET = "tests/data/datasets/half-cheetah-slope20-vibration/1.0.0"
SAY_EVERY = 50
ATTEMPTS = 10
NOTES = (
    "A case is a sound file, damaged in one way: a field that has another value, by a table of values, or whatever a "
    "random number generator of the seed chooses; with digests, seals and checksums made right again. It is then read "
    "and asked in a forked process with limits of CPU and wall time and memory.",
    "same answer: what the undamaged file says. another answer: one that is finite and of the right form, as a damaged "
    "number may be as good as the one that was there. refused: the documented error, at most one clear line a fault.",
    "Everything else is a fault: unsound (numbers that are not finite, an unclear error), traceback (another "
    "exception), memory, crash (a signal, a sanitizer's finding), hang, outside (a file beside its folder was read or "
    "written). places: how many fields were damaged, one by one.",
    "maps: loaded, asked for seven tasks one by one and together, exported, and planned with at three tasks. configs: "
    "scenarios, robots, profiles. datasets: what `labels` and `show` read. urdfs: imported, with the SRDF beside. "
    "map_bin: the exported file in C++ under ASan and UBSan.",
)


@dataclass(frozen=True)
class _Case:
    """What was done to a file, and what came of it."""

    what: str
    outcome: Outcome
    place: str = ""

    def beside(self, original: Outcome) -> _Case:
        return replace(self, outcome=self.outcome.beside(original))

    @property
    def fault(self) -> str | None:
        """What is wrong, None where nothing is."""
        if self.outcome.verdict in GOOD:
            return None
        return f"{self.outcome.verdict}: {self.place} {self.outcome.told}"


def run(checkout: Path, seed: int = 0, tasks: int | None = None) -> dict[str, Any]:
    """The document: a row a kind of file and of damage. `tasks` is how many cases of each kind there are at most."""
    rows: list[Row] = []
    for kind, own in CASES.items():
        with tempfile.TemporaryDirectory(prefix=f"hostile-{kind}-") as folder:
            judged = _of_map_bin if kind == "map_bin" else _of_folders
            found = []
            for case in judged(kind, checkout, Path(folder), own if tasks is None else tasks, seed):
                found.append(case)
                if case.fault is not None:
                    print(f"hostile {kind}: {case.what}: {case.fault!r}", file=sys.stderr, flush=True)
        for what in sorted({case.what for case in found}):
            cases = [case for case in found if case.what == what]
            places = len({case.place for case in cases if case.place})
            faults = [case.fault for case in cases if case.fault is not None]
            counts = _counts([case.outcome for case in cases])
            rows.append({"kind": kind, "what": what, **counts, "places": places, "faults": faults[:5]})
    return document("hostile", None, rows, summarise(rows) | {"seed": seed}, NOTES)


def summarise(rows: list[Row]) -> Row:
    """Of each kind of file the cases by verdict."""
    summary: Row = {}
    for kind in dict.fromkeys(row["kind"] for row in rows):
        total: Counter[str] = Counter()
        for row in rows:
            if row["kind"] == kind:
                total.update({key: n for key, n in row.items() if isinstance(n, int) and key != "places"})
        summary[kind] = dict(total)
    return summary


def _counts(outcomes: list[Outcome]) -> dict[str, int]:
    verdicts = Counter(str(each.verdict) for each in outcomes)
    faults = {verdict: count for verdict, count in verdicts.items() if verdict not in GOOD}
    return {"cases": len(outcomes), **{good: verdicts[good] for good in GOOD}, "fault": sum(faults.values()), **faults}


def _of_folders(kind: str, checkout: Path, scratch: Path, most: int, seed: int) -> Iterator[_Case]:
    module, sounds, originals = MODULES[kind], list[Path](), list[Outcome]()
    for i, source in enumerate(_sources(kind, checkout, scratch)):
        sounds.append(Path(shutil.copytree(source, scratch / f"sound-{i}")))
        originals.append(ask(partial(module.ask, sounds[i]), module.REFUSALS, _cpu_s(module)))
        if originals[i].verdict != "same answer":
            raise ValueError(f"{source}: the undamaged file gives {originals[i].verdict}: {originals[i].told}")
    damages = list(module.damages(sounds))
    if len(damages) > most:
        damages = random.Random(f"{seed} {kind}").sample(damages, most)
    for number, (i, damage) in enumerate(damages):
        _say(kind, number, len(damages))
        yield _one(module, damage, sounds[i], scratch, f"{seed} {kind} {number}").beside(originals[i])


def _one(module: ModuleType, damage: Damage, sound: Path, scratch: Path, seed: str) -> _Case:
    """A copy of the sound folder, damaged and asked; damage that its own writer refuses is tried again otherwise."""
    for attempt in range(ATTEMPTS):
        with _copied(sound, scratch) as (folder, outside):
            chance = random.Random(f"{seed} {attempt}")
            done = ask(partial(damage.do, folder, outside, chance), ())  # forked, as libraries start threads
            if done.verdict != "same answer":
                continue
            with _watched(outside) as was_touched:
                outcome = ask(partial(module.ask, folder), module.REFUSALS, _cpu_s(module), outside)
            what = f"{damage.what} {done.told}".strip()
            return _Case(what, Outcome("outside", outcome.told) if was_touched() else outcome, damage.place)
    raise RuntimeError(f"{sound} could not be damaged by {damage.what} {damage.place}, seed {seed!r}: {done.told}")


def _cpu_s(module: ModuleType) -> int:
    return PLANNING_CPU_S if module is maps else CPU_S


def _of_map_bin(kind: str, checkout: Path, scratch: Path, most: int, seed: int) -> Iterator[_Case]:
    program, file = map_bin.built(checkout, scratch / "ask_map"), scratch / "map.bin"
    originals = []
    for model in MODELS:
        content = map_bin.exported(checkout / "models" / model)
        file.write_bytes(content)
        original = map_bin.ask(program, file, _places())
        if original.verdict != "same answer":
            raise ValueError(f"{model}: the undamaged file gives {original.verdict}: {original.told}")
        originals.append((content, original))
    for number in range(most):
        _say(kind, number, most)
        content, original = originals[number % len(originals)]
        what, bad = map_bin.damaged(content, random.Random(f"{seed} {kind} {number}"))
        file.write_bytes(bad)
        yield _Case(what, map_bin.ask(program, file, _places())).beside(original)


def _say(kind: str, number: int, cases: int) -> None:
    if number % SAY_EVERY == 0:
        print(f"hostile {kind}: {number} of {cases}", file=sys.stderr, flush=True)


def _places() -> str:
    return "0.9 0.6\n1.3 0.5\n0.4 0.8\n0.75 0.55\n"


def _sources(kind: str, checkout: Path, scratch: Path) -> list[Path]:
    if kind == "maps":
        return [checkout / "models" / model for model in (*MODELS, *OLDER)]
    if kind == "datasets":
        return [checkout / DATASET]
    (scratch / kind).mkdir()
    if kind == "configs":
        configs.prepare(checkout, scratch / kind)
    else:
        urdfs.prepare(scratch / kind)
    return [scratch / kind]


@contextmanager
def _copied(sound: Path, scratch: Path) -> Iterator[tuple[Path, Path]]:
    """A copy to damage, and a folder beside it that nothing may touch."""
    with tempfile.TemporaryDirectory(dir=scratch) as folder:
        outside = Path(folder) / "outside"
        outside.mkdir()
        yield Path(shutil.copytree(sound, Path(folder) / "1.0.0")), outside


@contextmanager
def _watched(outside: Path) -> Iterator[Callable[[], bool]]:
    """Says afterwards whether a file was read, by its time of access, which the file system has to keep, or written."""
    probe = outside / ".probe"
    probe.write_bytes(b"x")
    files = [path for path in outside.iterdir() if path.is_file()]
    for path in files:
        os.utime(path, (0, path.stat().st_mtime))
    probe.read_bytes()
    if probe.stat().st_atime == 0:
        raise ValueError(f"{outside}: this file system keeps no times of access, so reads cannot be seen; set TMPDIR")
    before = _written(outside)

    def was_touched() -> bool:
        read = any(path.stat().st_atime != 0 for path in files if path != probe)
        return read or _written(outside) != before

    yield was_touched


def _written(folder: Path) -> dict[str, int]:
    """The files in a folder with the time [ns] at which each was written."""
    return {path.name: path.stat().st_mtime_ns for path in folder.iterdir()}
