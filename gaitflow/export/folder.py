"""A folder of files that is written whole or not at all, and takes the place of nothing but an earlier one."""

from __future__ import annotations

import errno
import os
import secrets
import shutil
from collections.abc import Collection, Mapping
from pathlib import Path

from gaitflow.export.graph import CannotExport
from gaitflow.files import WriteError, atomic_write, sync_folder


def refuse_foreign(folder: Path, known: Collection[str]) -> None:
    """Raises CannotExport unless `folder` is free, empty, or holds nothing but an earlier export: names in `known`."""
    if not folder.exists() and not folder.is_symlink():
        return
    if folder.is_symlink() or not folder.is_dir():
        raise CannotExport(f"{folder}: is not a folder; give the name of a new one")
    names = sorted(entry.name for entry in folder.iterdir())
    if foreign := [name for name in names if name not in known]:
        raise CannotExport(
            f"{folder}: holds {foreign[0]!r}, which no export writes, and nothing but an earlier export is replaced; "
            "give the name of a new folder"
        )


def write_folder(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write `files`, by name, as `folder`, in place of an earlier export.

    Raises CannotExport as `refuse_foreign`, WriteError when the disk refuses; then all is as it was.
    """
    refuse_foreign(folder, files)
    mark = f"{os.getpid()}-{secrets.token_hex(4)}"
    scratch, aside = (folder.parent / f".{folder.name}.{mark}.{kind}" for kind in ("new", "old"))
    try:
        for name, content in files.items():
            atomic_write(scratch / name, content)
        try:
            _swap(scratch, folder, aside)
        except OSError as error:
            raise WriteError(error.errno or errno.EIO, f"{folder}: cannot be written ({error.strerror})") from error
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    shutil.rmtree(aside, ignore_errors=True)


def _swap(scratch: Path, folder: Path, aside: Path) -> None:
    replaced = folder.exists()
    if replaced:
        os.rename(folder, aside)
    try:
        os.rename(scratch, folder)
    except OSError:
        if replaced:
            os.rename(aside, folder)
        raise
    sync_folder(folder.parent)
