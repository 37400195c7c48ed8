"""Ways to damage bytes and plain data, by a random number generator."""

from __future__ import annotations

import copy
import random
from typing import Any

ODD: tuple[Any, ...] = (
    None, True, -1, 0, 1.5, 10**9, 2**63, 10**400, 1e308, -1e308, 5e-324, float("nan"), float("inf"), "", "x" * 5000,
    "../../outside", "\0", "\n", "é\u202e", "NaN", "1e9", [], {}, [[]], [None], {"": None}, {"a": {"b": {}}},
)  # fmt: skip
DEPTH = 5000


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


def damaged_data(data: Any, chance: random.Random) -> tuple[str, Any]:
    """How plain data were damaged, and what came of it: a value of another kind, one missing or too much, depth."""
    data = copy.deepcopy(data)
    places = list(_places(data))
    holder, key = chance.choice(places)
    how = chance.choice(["odd", "odd", "odd", "missing", "extra", "swap", "scale", "deep", "many"])
    value = holder[key]
    match how:
        case "missing":
            del holder[key]
        case "extra" if isinstance(holder, dict):
            holder[chance.choice(["extra", "", "__class__", key + " ", "sha256"])] = chance.choice(ODD)
        case "swap":
            other, place = chance.choice(places)
            holder[key], other[place] = copy.deepcopy(other[place]), value
        case "scale" if isinstance(value, int | float):
            holder[key] = value * chance.choice([-1, 0, 1e-300, 1e3, 1e15, 1e300])
        case "deep":
            for _ in range(DEPTH // 20):
                value = [value] if chance.random() < 0.5 else {"a": value}
            holder[key] = value
        case "many":
            holder[key] = [value] * chance.choice([0, 2, 5000])
        case _:
            holder[key] = chance.choice(ODD)
    return how, data


def _places(data: Any) -> Any:
    """Every (holder, key) in plain data."""
    keys = list(data) if isinstance(data, dict) else list(range(len(data))) if isinstance(data, list) else []
    for key in keys:
        yield data, key
        yield from _places(data[key])
