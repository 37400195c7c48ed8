"""Every field of JSON data, made wrong in every way that JSON has."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from typing import Any

Path = tuple[str | int, ...]
DEPTH = 200  # lists one inside the other, which a reader still parses
UNPRINTABLE = "a\n\x1b[31m\u202e"


def _other_length(value: Any, by: int) -> Any:
    if type(value) not in (list, str) or not value:
        return value
    return value[:-1] if by < 0 else value + value[-1:]


def _nested(value: Any) -> Any:
    for _ in range(DEPTH):
        value = [value]
    return value


# What a field may become, by the name of the damage. A field that would stay as it is has no such damage.
ODDITIES: dict[str, Callable[[Any], Any]] = {
    "null": lambda value: None,
    "text": lambda value: "x",
    "empty text": lambda value: "",
    "unprintable text": lambda value: UNPRINTABLE,
    "number as text": lambda value: str(value),
    "NaN as text": lambda value: "NaN",
    "boolean": lambda value: True,
    "list": lambda value: [value],
    "object": lambda value: {"a": value},
    "empty list": lambda value: [],
    "huge integer": lambda value: 10**400,
    "1e308": lambda value: 1e308,
    "smallest number": lambda value: 5e-324,
    "negative": lambda value: -value if type(value) in (int, float) and value > 0 else -1,
    "zero": lambda value: 0,
    "deep": _nested,
    "shorter": lambda value: _other_length(value, -1),
    "longer": lambda value: _other_length(value, 1),
    "another field": lambda value: value | {UNPRINTABLE: 1} if isinstance(value, dict) else value,
}
MISSING = "missing"


def fields_of(data: Any, alike: Callable[[str], str] = str, path: Path = ()) -> Iterator[Path]:
    """Where every field is; of a list the first item, of fields whose names are one to `alike` the first."""
    keys: list[str | int] = []
    if isinstance(data, dict):
        keys = list({alike(key): key for key in reversed(data)}.values())[::-1]
    elif isinstance(data, list):
        keys = [0] if data else []
    for key in keys:
        yield (*path, key)
        yield from fields_of(data[key], alike, (*path, key))


def oddities_of(data: Any, path: Path) -> list[str]:
    """The damages that a field can have."""
    value = value_at(data, path)
    return [MISSING, *(name for name, change in ODDITIES.items() if not _same(change(value), value))]


def damaged_field(data: Any, path: Path, oddity: str) -> Any:
    """The data with one field damaged; `data` is not changed."""
    data = copy.deepcopy(data)
    holder, key = value_at(data, path[:-1]), path[-1]
    if oddity == MISSING:
        del holder[key]
    else:
        holder[key] = ODDITIES[oddity](holder[key])
    return data


def value_at(data: Any, path: Path) -> Any:
    """What is at a place."""
    for key in path:
        data = data[key]
    return data


def _same(one: Any, other: Any) -> bool:
    return type(one) is type(other) and bool(one == other)
