"""What is old and unfinished goes, what may still be in work stays."""

from __future__ import annotations

import os
import time

from gaitflow.store.leftovers import remove_leftovers
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit


def test_only_old_temporary_files_are_removed(store: UnitStore, units: tuple[Unit, ...]) -> None:
    shelf = store.path(units[0].digest).parent
    shelf.mkdir(parents=True)
    old, new = shelf / ".a.1-0.tmp", shelf / ".b.1-0.tmp"
    for file in (old, new):
        file.write_bytes(b"half")
    os.utime(old, (time.time() - 7200,) * 2)
    assert remove_leftovers(store.folder) == 1
    assert new.exists() and not old.exists()


def test_solves_that_nobody_went_on_with_for_a_month_are_removed(store: UnitStore, units: tuple[Unit, ...]) -> None:
    for unit, days in zip(units, (31, 29), strict=False):
        folder = store.unfinished(unit.digest)
        folder.mkdir(parents=True)
        os.utime(folder, (time.time() - days * 86400,) * 2)
    remove_leftovers(store.folder)
    assert store.begun() == {units[1].digest}
