"""Reading a map's files: sizes are checked before a file is read, digests before its content is used."""

from __future__ import annotations

import hashlib
import os
import stat
from dataclasses import dataclass
from pathlib import Path

from gaitflow.core.errors import ArtifactError

MANIFEST = "manifest.json"
CARD = "README.md"
CLASSIFIER = "classifier.onnx"
WARM_STARTS = "warmstarts.safetensors"
ATLAS = "atlas.safetensors"
PROBLEM_CHECK = "problem_check.safetensors"
PROBLEM = "problem.casadi"  # of formats 1 and 2

CONTENT = (CARD, CLASSIFIER, WARM_STARTS, ATLAS, PROBLEM_CHECK)  # every file of a map but the manifest

# Largest size of each file [bytes]: far above what a map needs, far below what a machine has.
LIMITS = {
    MANIFEST: 8_000_000,
    CARD: 1_000_000,
    CLASSIFIER: 64_000_000,
    WARM_STARTS: 512_000_000,
    ATLAS: 512_000_000,
    PROBLEM_CHECK: 64_000_000,
    PROBLEM: 128_000_000,
}


@dataclass(frozen=True)
class FileEntry:
    """What the manifest says of one file: SHA-256 in lower-case hexadecimal, size in bytes."""

    sha256: str
    bytes: int


def entry_of(content: bytes) -> FileEntry:
    """The entry that `content` must have in a manifest."""
    return FileEntry(hashlib.sha256(content).hexdigest(), len(content))


def read_limited(path: Path, limit: int) -> bytes:
    """The whole of a regular file of at most `limit` bytes; a link is not followed. Raises ArtifactError."""
    try:
        # Non-blocking, so that a pipe put in a file's place is refused below instead of waited for.
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0))
    except OSError as error:
        raise ArtifactError(f"{path}: cannot be read ({error.strerror}); publish or copy the map again") from None
    status = os.fstat(descriptor)
    if not stat.S_ISREG(status.st_mode):
        os.close(descriptor)  # `open` takes no descriptor of a folder
        raise ArtifactError(f"{path}: not a regular file; copy the map again")
    with open(descriptor, "rb") as file:
        if status.st_size > limit:
            raise ArtifactError(f"{path}: {status.st_size} bytes; this file may have at most {limit}")
        return file.read(status.st_size)


def read_checked(folder: Path, name: str, entry: FileEntry) -> bytes:
    """A file of the artifact, equal in size and SHA-256 to its entry in the manifest. Raises ArtifactError."""
    return read_checked_as(folder / name, FileEntry(entry.sha256, min(LIMITS[name], entry.bytes)))


def read_checked_as(path: Path, entry: FileEntry) -> bytes:
    """A file, equal in size and SHA-256 to `entry`. Raises ArtifactError."""
    content = read_limited(path, entry.bytes)
    if entry_of(content) != entry:
        raise ArtifactError(
            f"{path}: its content is not what the manifest lists (SHA-256 or size differs): "
            "the file is damaged or was edited; copy the map again or publish a new version"
        )
    return content
