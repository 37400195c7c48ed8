"""A certificate that was stopped makes none of its plans again, and takes none that is not its own."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from gaitflow.execute.map_processes import Asked
from gaitflow.pipeline import kept_plans as module
from gaitflow.pipeline.kept_plans import kept_plans
from gaitflow.runtime.files import entry_of

ASKED: list[Asked] = [({"speed": 0.1 * number, "cycle_duration": 0.6}, None) for number in range(4)]
TROT, NONE = ("trot", 1.2345678901234567), ("walking", None)


def manifest(content: bytes = b"atlas") -> Any:
    return SimpleNamespace(scenario_digest="scenario", files={"atlas": entry_of(content)})


def filled(path: Path) -> None:
    with kept_plans(path, manifest(), ASKED) as kept:
        assert kept.plans == []
        assert [kept.add(plan) for plan in (TROT, NONE)] == [1, 2]


def test_plans_are_found_again(tmp_path: Path) -> None:
    path = tmp_path / "new" / "plans.jsonl"
    filled(path)
    with kept_plans(path, manifest(), ASKED) as kept:
        assert kept.plans == [TROT, NONE]
        assert kept.add(TROT) == 1
    with kept_plans(path, manifest(), ASKED) as kept:
        assert kept.plans == [TROT, NONE, TROT]


def test_a_line_that_was_cut_off_is_dropped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "package_digest", lambda sources: "code")  # reading all code takes 0.1 s a cut
    path = tmp_path / "plans.jsonl"
    filled(path)
    whole = path.read_bytes()
    for cut in range(1, len(whole)):
        path.write_bytes(whole[:cut])
        with kept_plans(path, manifest(), ASKED) as kept:
            assert kept.plans == [TROT, NONE][: max(whole[:cut].count(b"\n") - 1, 0)]
            for plan in [TROT, NONE][len(kept.plans) :]:
                kept.add(plan)
        assert path.read_bytes() == whole


@pytest.mark.parametrize("damaged", [b"\xff\xfe", b"[1, 2, 3]", b"{"])
def test_nothing_is_taken_from_a_damaged_line_on(tmp_path: Path, damaged: bytes) -> None:
    path = tmp_path / "plans.jsonl"
    filled(path)
    head, first, second, _ = path.read_bytes().split(b"\n")
    path.write_bytes(b"\n".join([head, first, damaged, second, b""]))
    with kept_plans(path, manifest(), ASKED) as kept:
        assert kept.plans == [TROT]


@pytest.mark.parametrize("changed", ["map", "tasks", "code"])
def test_plans_of_something_else_are_dropped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changed: str) -> None:
    path = tmp_path / "plans.jsonl"
    filled(path)
    if changed == "code":
        monkeypatch.setattr(module, "package_digest", lambda sources: "another")
    asked = ASKED[:-1] if changed == "tasks" else ASKED
    with kept_plans(path, manifest(b"other" if changed == "map" else b"atlas"), asked) as kept:
        assert kept.plans == []
