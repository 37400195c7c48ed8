"""Compaction: the many small parts of a store moved into a few packs, as file systems of compute centres ask for.

Pack, make it durable, read it back, and only then remove the small files: at any moment every part is in one of the
two, so a kill loses nothing, and the next compaction goes on. A run may be on meanwhile.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from gaitflow.files import WriteError, sync_folder
from gaitflow.store.known_parts import remember, remembered, stamp
from gaitflow.store.pack import Pack, open_pack, write_pack
from gaitflow.store.parts import DamagedPart, UnitStore
from gaitflow.tables.provenance import read_record

MAX_PACK_BYTES = 1 << 30
Part = tuple[str, int]  # digest and length


class NotPacked(ValueError):
    """A pack could not be read back as it was written; the small files are kept. The message names the pack."""


@dataclass
class Compacted:
    """What a compaction did: parts that moved, into how many new packs, bytes, damaged parts by digest."""

    parts: int = 0
    packs: int = 0
    bytes: int = 0
    damaged: dict[str, str] = field(default_factory=dict)


def compact(store: UnitStore, max_bytes: int = MAX_PACK_BYTES) -> Compacted:
    """Move every part that is a file of its own into packs of at most `max_bytes`; a damaged one goes to quarantine.

    Raises NotPacked, WriteError.
    """
    done, known = Compacted(), remembered(store)
    _remove_twins(store)
    for group in _groups(_sound(store, done), max_bytes):
        if len(group) == 1:  # a pack of one part is no gain
            continue
        pack = _packed(store, group)
        digests = [digest for digest, _ in group]
        checked = [digest for digest in digests if stamp(store, digest) in known]
        _remove(store, digests)
        remember(store, [line for digest in checked if (line := stamp(store, digest)) is not None])
        done.parts, done.packs = done.parts + len(group), done.packs + 1
        done.bytes += pack.path.stat().st_size
    return done


def _packed(store: UnitStore, group: Sequence[Part]) -> Pack:
    """A durable pack of these parts, read back and found equal to them, byte by byte."""
    path = write_pack(store.packs.folder, group, store.part)
    _forget(path)
    pack = open_pack(path)
    for number, (digest, expected) in enumerate(zip(pack.digests(), sorted(group), strict=True)):
        if digest != expected[0] or pack.read(number) != store.part(digest):
            raise NotPacked(f"{path}: part {digest} came back different from that disk; the small files are kept")
    return pack


def _sound(store: UnitStore, done: Compacted) -> Iterator[Part]:
    """Digest and length of every small file that is a sound part of the unit that it is named after."""
    for digest in sorted(name[:64] for name in store.loose()):
        try:
            data = store.part(digest)
            name = read_record(pq.read_metadata(pa.BufferReader(data)).metadata, str(store.path(digest)))["unit_digest"]
            if name != digest:
                raise DamagedPart(f"{store.path(digest)}: foreign: it holds the unit {name}")
        except (pa.ArrowException, ValueError, KeyError) as error:
            store.quarantine(digest, str(error))
            done.damaged[digest] = str(error)
            continue
        yield digest, len(data)


def _groups(parts: Iterator[Part], max_bytes: int) -> Iterator[list[Part]]:
    group, total = list[Part](), 0
    for part in parts:
        if group and total + part[1] > max_bytes:
            yield group
            group, total = [], 0
        group.append(part)
        total += part[1]
    if group:
        yield group


def _remove_twins(store: UnitStore) -> None:
    """Remove small files whose very bytes are in a pack: a compaction was killed before it came to them."""
    packed = {digest for pack in store.packs.all() for digest in pack.digests()}
    if packed:
        sync_folder(store.packs.folder)  # the kill may have come just before that
    for digest in sorted(packed.intersection(name[:64] for name in store.loose())):
        found = store.packs.find(digest)
        if found is not None and found[0].read(found[1]) == store.path(digest).read_bytes():
            _remove(store, [digest])


def _remove(store: UnitStore, digests: Sequence[str]) -> None:
    try:
        for digest in digests:
            store.path(digest).unlink(missing_ok=True)
        for shelf in {store.path(digest).parent for digest in digests}:
            sync_folder(shelf)
    except OSError as error:
        raise WriteError(error.errno or 0, f"{store.folder}: packed parts cannot be removed ({error})") from error


def _forget(path: Path) -> None:
    """Ask the system to drop its copy of a durable file, so that reading it back reads the disk."""
    if hasattr(os, "posix_fadvise"):
        with open(path, "rb") as file:
            os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)
