"""What damage is, and ways to damage bytes by a random number generator."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Damage:
    """What is done to the files in a folder, and to which field of theirs where that is known beforehand.

    `do` takes the folder, another one that nothing may read from, and a random number generator; it gives what it did
    in a word, which is empty where `what` says it all. It may raise where the file's own writer refuses.
    """

    what: str
    place: str
    do: Callable[[Path, Path, random.Random], str]


def damaged_bytes(content: bytes, chance: random.Random) -> tuple[str, bytes]:
    """How bytes were damaged, and what came of it: flipped bits, a cut, a hole, a repeated or a foreign piece."""
    how = chance.choice(["flip", "flip", "cut", "hole", "repeat", "foreign"])
    data = bytearray(content)
    at = chance.randrange(len(data)) if data else 0
    length = min(len(data) - at, chance.choice([1, 4, 8, 100, 4096]))
    match how:
        case "flip":
            for _ in range(chance.choice([1, 1, 3, 20])):
                data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
        case "cut":
            del data[at:]
        case "hole":
            del data[at : at + length]
        case "repeat":
            data[at:at] = data[at : at + length] * chance.choice([1, 100])
        case _:
            data[at : at + length] = chance.choice([b"\0", b"\xff", bytes(range(256))]) * length
    return how, bytes(data)
