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
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from benchmarks.document import document
from benchmarks.hostile import configs, datasets, map_bin, maps
from benchmarks.hostile.sandbox import GOOD, Outcome, ask
from benchmarks.rows import Row

CASES = {"maps": 1000, "configs": 500, "datasets": 500, "map_bin": 500}
MODELS = (
    "half-cheetah-exact-vibration/1.1.0",  # of layers
    "half-cheetah-exact-effort/1.1.0",  # support vectors
    "half-cheetah-exact-slope20-vibration/1.1.0",  # neighbours
    "go1-energy/1.0.0",  # trees
)
DATASET = "tests/data/datasets/half-cheetah-slope20-vibration/1.0.0"
SAY_EVERY = 50
ATTEMPTS = 10
NOTES = (
    "A case is a sound file, damaged in one way by a random number generator of the seed, with digests, seals and "
    "checksums made right again; then read and asked in a forked process with limits of CPU and wall time and memory.",
    "same answer: what the undamaged file says. another answer: one that is finite and of the right form, as a damaged "
    "number may be as good as the one that was there. refused: the documented error, at most one clear line a fault.",
    "Everything else is a fault: unsound (numbers that are not finite, an unclear error), traceback (another "
    "exception), memory, crash (a signal, a sanitizer's finding), hang, outside (a file beside its folder was read).",
    "maps: loaded and asked for seven tasks, every 25th for a motion, too. configs: scenarios, robots, profiles, "
    "URDFs. datasets: what `labels` and `show` read. map_bin: the exported file in C++ under ASan and UBSan.",
)


@dataclass(frozen=True)
class _Case:
    """What was done to a file, and what came of it."""

    what: str
    outcome: Outcome

    def beside(self, original: Outcome) -> _Case:
        return _Case(self.what, self.outcome.beside(original))


def run(checkout: Path, seed: int = 0, tasks: int | None = None) -> dict[str, Any]:
    """The document: a row a kind of file and of damage. `tasks` is how many cases of each kind there are."""
    rows: list[Row] = []
    for kind, own in CASES.items():
        cases = own if tasks is None else tasks
        with tempfile.TemporaryDirectory(prefix=f"hostile-{kind}-") as folder:
            found = list(_judged(kind, checkout, Path(folder), cases, seed))
        for what in sorted({case.what for case in found}):
            outcomes = [case.outcome for case in found if case.what == what]
            faults = [f"{each.verdict}: {each.told}" for each in outcomes if each.verdict not in GOOD]
            rows.append({"kind": kind, "what": what, **_counts(outcomes), "faults": faults[:5]})
    return document("hostile", None, rows, summarise(rows) | {"seed": seed}, NOTES)


def summarise(rows: list[Row]) -> Row:
    """Of each kind of file the cases by verdict."""
    summary: Row = {}
    for kind in dict.fromkeys(row["kind"] for row in rows):
        total: Counter[str] = Counter()
        for row in rows:
            if row["kind"] == kind:
                total.update({key: value for key, value in row.items() if isinstance(value, int)})
        summary[kind] = dict(total)
    return summary


def _counts(outcomes: list[Outcome]) -> dict[str, int]:
    verdicts = Counter(str(each.verdict) for each in outcomes)
    faults = {verdict: count for verdict, count in verdicts.items() if verdict not in GOOD}
    return {"cases": len(outcomes), **{good: verdicts[good] for good in GOOD}, "fault": sum(faults.values()), **faults}


def _judged(kind: str, checkout: Path, scratch: Path, cases: int, seed: int) -> Iterator[_Case]:
    done = _of_map_bin if kind == "map_bin" else _of_folders
    for number, judged in enumerate(done(kind, checkout, scratch, cases, seed)):
        if number % SAY_EVERY == 0:
            print(f"hostile {kind}: {number} of {cases}", file=sys.stderr, flush=True)
        yield judged


def _of_folders(kind: str, checkout: Path, scratch: Path, cases: int, seed: int) -> Iterator[_Case]:
    modules: dict[str, ModuleType] = {"maps": maps, "configs": configs, "datasets": datasets}
    module, originals = modules[kind], list[tuple[Path, Outcome]]()
    for i, source in enumerate(_sources(kind, checkout, scratch)):
        folder = Path(shutil.copytree(source, scratch / f"sound-{i}"))
        original = ask(partial(module.ask, folder, 1), module.REFUSALS)
        if original.verdict != "same answer":
            raise ValueError(f"{source}: the undamaged file gives {original.verdict}: {original.told}")
        originals.append((folder, original))
    for number in range(cases):
        folder, original = originals[number % len(originals)]
        yield _one(module, folder, scratch, number, f"{seed} {kind} {number}").beside(original)


def _one(module: ModuleType, sound: Path, scratch: Path, number: int, seed: str) -> _Case:
    """A copy of the sound folder, damaged and asked; damage that its own writer refuses is not one, so another is."""
    for attempt in range(ATTEMPTS):
        with _copied(sound, scratch) as (folder, outside):
            chance = random.Random(f"{seed} {attempt}")
            damage = ask(partial(module.damage, folder, outside, chance), ())  # forked, as libraries start threads
            if damage.verdict != "same answer":
                continue
            with _watched(outside) as was_read:
                outcome = ask(partial(module.ask, folder, number), module.REFUSALS)
            return _Case(str(damage.told), Outcome("outside", outcome.told) if was_read() else outcome)
    raise RuntimeError(f"{sound} could not be damaged by the seed {seed!r}: {damage}")


def _of_map_bin(kind: str, checkout: Path, scratch: Path, cases: int, seed: int) -> Iterator[_Case]:
    program, file = map_bin.built(checkout, scratch / "ask_map"), scratch / "map.bin"
    originals = []
    for model in MODELS:
        content = map_bin.exported(checkout / "models" / model)
        file.write_bytes(content)
        original = map_bin.ask(program, file, _places())
        if original.verdict != "same answer":
            raise ValueError(f"{model}: the undamaged file gives {original.verdict}: {original.told}")
        originals.append((content, original))
    for number in range(cases):
        content, original = originals[number % len(originals)]
        what, bad = map_bin.damaged(content, random.Random(f"{seed} {kind} {number}"))
        file.write_bytes(bad)
        yield _Case(what, map_bin.ask(program, file, _places())).beside(original)


def _places() -> str:
    return "0.9 0.6\n1.3 0.5\n0.4 0.8\n0.75 0.55\n"


def _sources(kind: str, checkout: Path, scratch: Path) -> list[Path]:
    if kind == "maps":
        return [checkout / "models" / model for model in MODELS]
    if kind == "datasets":
        return [checkout / DATASET]
    (scratch / "configs").mkdir()
    configs.prepare(checkout, scratch / "configs")
    return [scratch / "configs"]


@contextmanager
def _copied(sound: Path, scratch: Path) -> Iterator[tuple[Path, Path]]:
    """A copy to damage, and a folder beside it that nothing may read from."""
    with tempfile.TemporaryDirectory(dir=scratch) as folder:
        outside = Path(folder) / "outside"
        outside.mkdir()
        yield Path(shutil.copytree(sound, Path(folder) / "1.0.0")), outside


@contextmanager
def _watched(outside: Path) -> Iterator[Callable[[], bool]]:
    """Says afterwards whether a file was read: by its time of access, which the file system has to keep."""
    probe = outside / ".probe"
    probe.write_bytes(b"x")
    files = [path for path in outside.iterdir() if path.is_file()]
    for path in files:
        os.utime(path, (0, path.stat().st_mtime))
    probe.read_bytes()
    if probe.stat().st_atime == 0:
        raise ValueError(f"{outside}: this file system keeps no times of access, so reads cannot be seen; set TMPDIR")
    yield lambda: any(path.stat().st_atime != 0 for path in files if path != probe)
