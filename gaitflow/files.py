"""Atomic, durable file writes, and paths that stay inside a folder."""

from __future__ import annotations

import errno
import hashlib
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

TEMPORARY = ".tmp"  # suffix of a file that is being written; nothing reads such a file


class WriteError(OSError):
    """A file could not be written: names the path, the cause and the way out. Nothing was left behind."""

    def __str__(self) -> str:
        return str(self.strerror)


class _Taken(Exception):
    pass


@contextmanager
def new_file(path: Path, *, replace: bool) -> Iterator[BinaryIO]:
    """Open a temporary file beside `path`; when the block ends well, make it durable and give it its name.

    `replace=True` takes the place of an older file; `replace=False` raises FileExistsError when the name is taken,
    so that of several writers the first one that completes wins. The file is readable and seekable inside the block.
    An exception in the block removes the temporary file. Raises WriteError when the system refuses a write.
    """
    temporary = path.parent / f".{path.name}.{os.getpid()}-{secrets.token_hex(4)}{TEMPORARY}"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with open(temporary, "xb+") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        if replace:
            os.replace(temporary, path)
        else:
            _link_once(temporary, path)
        sync_folder(path.parent)
    except _Taken:
        raise FileExistsError(errno.EEXIST, "was written before; the first complete file stays", str(path)) from None
    except OSError as error:
        raise _explained(path, error) from error
    finally:
        with suppress(OSError):
            temporary.unlink()


def atomic_write(path: Path, data: bytes) -> None:
    """Write or replace `path` as a whole: a reader sees the old bytes or the new ones. Raises WriteError."""
    with new_file(path, replace=True) as file:
        file.write(data)


def publish_once(path: Path, data: bytes) -> bool:
    """Write `path` unless it exists: True when these bytes are the ones that stay. Raises WriteError."""
    try:
        with new_file(path, replace=False) as file:
            file.write(data)
    except FileExistsError:
        return False
    return True


def make_folder(path: Path) -> None:
    """Make a folder, and those above it, in which files can be written. Raises WriteError."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _explained(path, error) from None
    if not os.access(path, os.W_OK | os.X_OK):
        raise _explained(path, OSError(errno.EACCES, os.strerror(errno.EACCES)))


def sha256_file(path: Path) -> str:
    """SHA-256 of a file's bytes, hexadecimal. Raises OSError."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def inside(folder: Path, name: str) -> Path:
    """`folder / name`, refused with ValueError when that is the folder itself or lies outside it (.., links)."""
    root = folder.resolve()
    path = (root / name).resolve()
    if "\0" in name or path == root or not path.is_relative_to(root):
        raise ValueError(f"{name!r}: leads out of {folder}; give a name inside that folder")
    return path


def _link_once(temporary: Path, path: Path) -> None:
    try:
        os.link(temporary, path)
    except FileExistsError:
        raise _Taken from None


def sync_folder(folder: Path) -> None:
    """Make the names in a folder durable: a new one is only once its folder is. Raises OSError."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _explained(path: Path, error: OSError) -> WriteError:
    reason = error.strerror or str(error)
    way_out = {
        errno.ENOSPC: "; free some space on that disk and run again, complete files were kept",
        errno.EDQUOT: "; your quota there is used up: free some space and run again, complete files were kept",
        errno.ENOTDIR: "; what lies above it is a file, choose another folder",
        errno.EEXIST: "; what lies above it is a file, choose another folder",
        errno.EACCES: "; give yourself the right to write there, or choose another folder",
        errno.EROFS: "; that disk is read-only, choose another folder",
        errno.EPERM: "; the file system may not support hard links, choose a folder on another one",
        errno.EOPNOTSUPP: "; the file system does not support hard links, choose a folder on another one",
    }.get(error.errno or 0, "")
    return WriteError(error.errno or errno.EIO, f"{path}: cannot be written ({reason}){way_out}")
