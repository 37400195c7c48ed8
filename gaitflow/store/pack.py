"""Packs: many parts of a store in one file, byte by byte as they were, found by one index.

    <folder>/packs/<SHA-256 of the index>.pack
    16 bytes  "gaitflow pack 1\\n"
    8 bytes   n, how many parts, little endian
    48 n      the index, by rising digest: digest (32 bytes), offset, length (8 bytes each, little endian)
    parts     back to back, in the index's order

The name seals the index and every part carries a seal of its own, so no byte is without one. A pack never changes.
"""

from __future__ import annotations

import hashlib
import os
import re
import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitflow.files import new_file

MAGIC = b"gaitflow pack 1\n"
NAME = re.compile(r"[0-9a-f]{64}\.pack")
_ENTRY = np.dtype([("digest", "u1", 32), ("offset", "<u8"), ("length", "<u8")])
_HEAD = struct.Struct("<16sQ")


class DamagedPack(ValueError):
    """A pack whose index cannot be trusted; the message names the file and what is wrong with it."""


@dataclass(frozen=True)
class Pack:
    """A pack's file and its index, rows of (digest, offset, length) by rising digest."""

    path: Path
    index: NDArray[np.void]

    def digests(self) -> list[str]:
        """Digests of all parts, hexadecimal, rising."""
        text = self.index["digest"].tobytes().hex()
        return [text[i : i + 64] for i in range(0, len(text), 64)]

    def find(self, digest: str) -> int | None:
        """Number of a unit's part in this pack; None when it is not here."""
        wanted = bytes.fromhex(digest)
        low, high = 0, len(self.index)
        while low < high:
            middle = (low + high) // 2
            here = self.index["digest"][middle].tobytes()
            if here == wanted:
                return middle
            low, high = (middle + 1, high) if here < wanted else (low, middle)
        return None

    def read(self, number: int) -> bytes:
        """The bytes of a part. Raises OSError."""
        entry = self.index[number]
        with open(self.path, "rb") as file:
            file.seek(int(entry["offset"]))
            return file.read(int(entry["length"]))


def open_pack(path: Path) -> Pack:
    """Read and check a pack's index. Raises DamagedPack, OSError when it cannot be read."""
    with open(path, "rb") as file:
        size = os.fstat(file.fileno()).st_size
        head = file.read(_HEAD.size)
        magic, count = _HEAD.unpack(head) if len(head) == _HEAD.size else (b"", 0)
        start = _HEAD.size + count * _ENTRY.itemsize
        if magic != MAGIC or start > size:
            raise DamagedPack(f"{path}: not a pack of gaitflow ({size} bytes): truncated, or something else")
        data = file.read(count * _ENTRY.itemsize)
    if hashlib.sha256(head + data).hexdigest() != path.stem:
        raise DamagedPack(f"{path}: damaged: its index does not match its name")
    index = np.frombuffer(data, dtype=_ENTRY)
    ends = np.concatenate([[np.uint64(start)], index["offset"] + index["length"]])
    inside = bool((index["offset"] <= size).all() and (index["length"] <= size).all())  # so that no sum wraps round
    if not inside or not np.array_equal(ends[:-1], index["offset"]) or int(ends[-1]) != size:
        raise DamagedPack(f"{path}: damaged: {size} bytes are not what its index tells")
    return Pack(path, index)


def write_pack(folder: Path, parts: Sequence[tuple[str, int]], read: Callable[[str], bytes]) -> Path:
    """Write a pack of (digest, length) parts durably into `folder` and return its path; the same parts, the same path.

    `read` gives a part's bytes. Raises WriteError, and ValueError when a part has not the length that was told.
    """
    ordered = sorted(parts)
    index = np.zeros(len(ordered), dtype=_ENTRY)
    offset = _HEAD.size + index.nbytes
    for row, (digest, length) in enumerate(ordered):
        index[row] = (np.frombuffer(bytes.fromhex(digest), "u1"), offset, length)
        offset += length
    head = _HEAD.pack(MAGIC, len(ordered)) + index.tobytes()
    path = folder / f"{hashlib.sha256(head).hexdigest()}.pack"
    with new_file(path, replace=True) as file:
        file.write(head)
        for digest, length in ordered:
            data = read(digest)
            if len(data) != length:
                raise ValueError(f"part {digest}: has {len(data)} bytes, had {length}: it changed while it was packed")
            file.write(data)
    return path


class Packs:
    """The packs of a store, below `folder`, as they are there at each call."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._open: dict[Path, Pack] = {}  # a pack never changes

    def all(self) -> Iterator[Pack]:
        """Every pack; one whose index is damaged is left out, see `damaged`. Raises OSError."""
        for path in self._paths():
            if path not in self._open:
                try:
                    self._open[path] = open_pack(path)
                except (DamagedPack, FileNotFoundError):
                    continue
            yield self._open[path]

    def find(self, digest: str) -> tuple[Pack, int] | None:
        """The pack that holds a unit's part, and the part's number in it. Raises OSError."""
        for pack in self.all():
            number = pack.find(digest)
            if number is not None:
                return pack, number
        return None

    def damaged(self) -> dict[Path, str]:
        """Packs whose index is damaged, with the reason each. Raises OSError."""
        reasons = {}
        for path in self._paths():
            try:
                open_pack(path)
            except DamagedPack as error:
                reasons[path] = str(error)
        return reasons

    def _paths(self) -> list[Path]:
        names = os.listdir(self.folder) if self.folder.is_dir() else []
        return [self.folder / name for name in sorted(names) if NAME.fullmatch(name)]
