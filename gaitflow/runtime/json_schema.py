"""Plain JSON data against a JSON Schema, for the part of the language that our configuration's schemas are written in.

A scenario in a manifest is checked by the schema of the same models that check one in YAML (`scenario.schema.json`,
written by `gaitflow.config.schemas`), without their library. Numbers are as strict as there: no booleans, none that a
float cannot hold, no 1.0 for an integer.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from reprlib import repr as short
from typing import Any

from gaitflow.runtime.strict import LONGEST, is_number, shown

Schema = Mapping[str, Any]

_SILENT = frozenset({"$schema", "$defs", "title", "description", "default", "type"})  # "type" is looked at first
_TYPES: dict[str, Callable[[Any], bool]] = {
    "object": lambda value: isinstance(value, dict),
    "array": lambda value: isinstance(value, list),
    "string": lambda value: isinstance(value, str),
    "integer": lambda value: type(value) is int and is_number(value),
    "number": is_number,
    "boolean": lambda value: isinstance(value, bool),
    "null": lambda value: value is None,
}
_LIMITS: dict[str, Callable[[Any, Any], bool]] = {
    "minimum": lambda value, limit: value >= limit,
    "maximum": lambda value, limit: value <= limit,
    "exclusiveMinimum": lambda value, limit: value > limit,
    "exclusiveMaximum": lambda value, limit: value < limit,
    "minItems": lambda value, limit: len(value) >= limit,
    "maxItems": lambda value, limit: len(value) <= limit,
    "minLength": lambda value, limit: len(value) >= limit,
    "maxLength": lambda value, limit: len(value) <= limit,
    "enum": lambda value, allowed: any(_same(value, each) for each in allowed),
    "const": lambda value, allowed: _same(value, allowed),
    "pattern": lambda value, pattern: re.fullmatch(pattern.removeprefix("^").removesuffix("$"), value) is not None,
}


def fault_of(data: Any, schema: Schema) -> str | None:
    """What of the data a schema does not allow, such as "mass = -1: does not fit minimum 0"; None where it allows all.

    Raises ValueError for a schema with a word that is not read here.
    """
    return _fault(data, schema, "", schema.get("$defs", {}))


def _fault(data: Any, schema: Schema, name: str, known: Schema) -> str | None:
    schema = _resolved(schema, known)
    if "type" in schema and not _TYPES[schema["type"]](data):
        return f"{name} = {short(data)[:LONGEST]}: must be of the type {schema['type']}"
    for word, value in schema.items():
        if word in _LIMITS:
            if not _LIMITS[word](data, value):
                return f"{name} = {short(data)[:LONGEST]}: does not fit {word} {short(value)}"
        elif word in ("anyOf", "oneOf"):
            faults = [_fault(data, form, name, known) for form in value]
            if None not in faults:
                return faults[_meant(data, value, known)]
        elif word == "required":
            if missing := [field for field in value if field not in data]:
                return f"{_inner(name, missing[0])}: is missing"
        elif word not in _SILENT and word not in _PARTS:
            raise ValueError(f"{word}: a word of JSON Schema that this module does not read")
    if schema.get("additionalProperties") is False and (odd := [each for each in data if each not in _named(schema)]):
        return f"{_inner(name, shown(odd[0]))}: is an unknown field"
    inside = [part for word, parts in _PARTS.items() if word in schema for part in parts(data, schema, name)]
    return next((fault for part in inside if (fault := _fault(*part, known)) is not None), None)


def _of_fields(data: Any, schema: Schema, name: str) -> list[tuple[Any, Schema, str]]:
    return [(data[key], form, _inner(name, key)) for key, form in schema["properties"].items() if key in data]


def _of_others(data: Any, schema: Schema, name: str) -> list[tuple[Any, Schema, str]]:
    form = schema["additionalProperties"]
    others = [key for key in data if key not in _named(schema)]
    return [(data[key], form, _inner(name, shown(key))) for key in others if isinstance(form, Mapping)]


def _of_names(data: Any, schema: Schema, name: str) -> list[tuple[Any, Schema, str]]:
    return [(key, schema["propertyNames"], _inner(name, shown(key))) for key in data]


def _of_first(data: Any, schema: Schema, name: str) -> list[tuple[Any, Schema, str]]:
    pairs = zip(data, schema["prefixItems"], strict=False)
    return [(each, form, f"{name}[{i}]") for i, (each, form) in enumerate(pairs)]


def _of_items(data: Any, schema: Schema, name: str) -> list[tuple[Any, Schema, str]]:
    return [(each, schema["items"], f"{name}[{i}]") for i, each in enumerate(data)]


# What a word says of parts of the data: each with its schema and its name.
_PARTS: dict[str, Callable[[Any, Schema, str], list[tuple[Any, Schema, str]]]] = {
    "properties": _of_fields,
    "additionalProperties": _of_others,
    "propertyNames": _of_names,
    "prefixItems": _of_first,
    "items": _of_items,
}


def _resolved(schema: Schema, known: Schema) -> Schema:
    return known[schema["$ref"].removeprefix("#/$defs/")] if "$ref" in schema else schema


def _meant(data: Any, forms: list[Schema], known: Schema) -> int:
    """Which of several forms was meant: the first one of the data's type."""
    types = [_resolved(form, known).get("type") for form in forms]
    return next((i for i, each in enumerate(types) if each is not None and _TYPES[each](data)), 0)


def _named(schema: Schema) -> Schema:
    named: Schema = schema.get("properties", {})
    return named


def _same(value: Any, other: Any) -> bool:
    return type(value) is type(other) and bool(value == other)


def _inner(name: str, field: str) -> str:
    return f"{name}.{field}" if name else field
