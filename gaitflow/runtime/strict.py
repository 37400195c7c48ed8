"""Typed access to parsed JSON that nobody has checked yet: every wrong field is named with its value."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise
from reprlib import repr as short
from typing import Any, NoReturn

from gaitflow.core.errors import ArtifactError

LONGEST = 200  # letters of a value in an error
LARGEST = 1e15  # of a stored number: far above what maps hold, and products of several are still finite


class Fields:
    """One JSON object of which each field is read once by its type; `where` is what errors call it.

    Every method raises ArtifactError when the field is missing or has another type or range.
    """

    def __init__(self, data: object, where: str, names: Iterable[str]) -> None:
        if not isinstance(data, dict):
            raise ArtifactError(f"{where}: expected an object, found {short(data)[:LONGEST]}")
        self._data: dict[str, Any] = data
        self._where = where
        names = set(names)
        for name in sorted(names ^ set(data)):
            fault = "missing field" if name in names else "unknown field"
            raise ArtifactError(f"{where}: {fault} {name[:80]!r}; publish the artifact again")

    def refuse(self, name: str, allowed: str) -> NoReturn:
        """Raise the error of a field that is not what is `allowed`."""
        raise ArtifactError(f"{self._where}.{name} = {short(self._data[name])[:LONGEST]}: must be {allowed}")

    def refuse_inner(self, name: str, fault: str) -> NoReturn:
        """Raise the error of what lies deeper in a field, `fault` being its place, its value and what it must be."""
        raise ArtifactError(
            f"{self._where}.{name}.{fault}; copy the map again, or use the gaitflow that `code` in it names"
        )

    def text(self, name: str, longest: int = 200) -> str:
        """A string of 1 to `longest` characters, all printable: errors and tables show it."""
        value = self._data[name]
        if not isinstance(value, str) or not 0 < len(value) <= longest or not value.isprintable():
            self.refuse(name, f"text of 1 to {longest} printable characters")
        return value

    def digest(self, name: str) -> str:
        """A SHA-256 in lower-case hexadecimal."""
        value = self._data[name]
        if not isinstance(value, str) or len(value) != 64 or value.strip("0123456789abcdef"):
            self.refuse(name, "a SHA-256 of 64 lower-case hexadecimal digits")
        return value

    def integer(self, name: str, low: int, high: int) -> int:
        """An integer from `low` to `high`, both allowed; not a boolean."""
        value = self._data[name]
        if type(value) is not int or not low <= value <= high:
            self.refuse(name, f"an integer from {low} to {high}")
        return value

    def positive(self, name: str) -> float:
        """A number above 0, at most LARGEST."""
        value = self._data[name]
        if not is_number(value) or not 0 < value <= LARGEST:
            self.refuse(name, f"a number above 0, at most {LARGEST:g}")
        return float(value)

    def rising(self, name: str, longest: int) -> tuple[float, ...]:
        """1 to `longest` finite numbers, each above the one before."""
        values = self.items(name, longest)
        if not all(map(is_number, values)) or any(b <= a for a, b in pairwise(values)):
            self.refuse(name, "finite numbers, each above the one before")
        return tuple(map(float, values))

    def items(self, name: str, longest: int) -> list[Any]:
        """A list of 1 to `longest` items."""
        value = self._data[name]
        if not isinstance(value, list) or not 0 < len(value) <= longest:
            self.refuse(name, f"a list of 1 to {longest} items")
        return value

    def mapping(self, name: str) -> dict[str, Any]:
        """An object of any fields."""
        value = self._data[name]
        if not isinstance(value, dict):
            self.refuse(name, "an object")
        return value

    def inner(self, name: str, names: Iterable[str]) -> Fields:
        """An object of exactly the fields `names`."""
        return Fields(self._data[name], f"{self._where}.{name}", names)


def is_number(value: object) -> bool:
    """Whether a value is a number, no boolean, that a float can hold."""
    return type(value) in (int, float) and abs(value) < 1e300 and math.isfinite(value)  # type: ignore[arg-type]


def shown(text: str, longest: int = 80) -> str:
    """A text that anybody may have written, as an error of one line can hold it."""
    return text[:longest] if text.isprintable() else repr(text[:longest])
