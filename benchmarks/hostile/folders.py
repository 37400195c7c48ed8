"""Damaged folders of maps: files cut, emptied, swapped, missing, linked, or no files at all."""

from __future__ import annotations

import os
import random
from pathlib import Path

WAYS = ("cut", "emptied", "swapped", "missing", "link", "link to a device", "pipe", "folder", "grown", "other case")
LARGE = 1 << 33


def damaged(path: Path, others: list[Path], outside: Path, chance: random.Random) -> str:
    """How one file was damaged; `others` are beside it, `outside` is a folder that nothing may read from."""
    how, content = chance.choice(WAYS), path.read_bytes()
    path.unlink()
    match how:
        case "cut":
            path.write_bytes(content[: chance.randrange(len(content))])
        case "emptied":
            path.write_bytes(b"")
        case "swapped":
            other = chance.choice([each for each in others if each != path])
            path.write_bytes(other.read_bytes())
            other.write_bytes(content)
        case "link":
            (outside / path.name).write_bytes(content)
            path.symlink_to(outside / path.name)
        case "link to a device":
            path.symlink_to("/dev/zero")
        case "pipe":
            os.mkfifo(path)
        case "folder":
            path.mkdir()
        case "grown":
            path.write_bytes(content)
            os.truncate(path, LARGE)  # a hole, which takes no room
        case "other case":
            path.with_name(path.name.upper()).write_bytes(content)
    return how
