"""Base of every configuration model: strict, frozen, unknown fields refused, errors in one line."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from pathlib import Path
from reprlib import repr as short
from typing import Any, ClassVar, Self, get_args

import yaml
from pydantic import BaseModel, ConfigDict, ValidationError

MAX_CONFIG_BYTES = 100_000  # which takes seconds to parse; real ones have some thousand
MAX_ERRORS = 20  # lines of one ConfigError
FORMS = ("(mapping)", "(value)")  # tags of the two forms that a field may have, which no error shows


class ConfigError(ValueError):
    """A configuration file that cannot be used: names the file, the field, the value and what is allowed."""


class FrozenDict(dict[str, Any]):
    """A mapping that cannot be changed, so that a frozen model with it can be hashed."""

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(frozenset(self.items()))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (dict(self),)

    def _refused(self, *_: Any, **__: Any) -> Any:
        raise TypeError("a configuration is frozen")

    __setitem__ = __delitem__ = __ior__ = _refused
    clear = pop = popitem = setdefault = update = _refused


class Config(BaseModel):
    """Frozen, strict data: nothing is coerced but int to float, nothing unknown is let through."""

    model_config = ConfigDict(frozen=True, strict=True, extra="forbid", allow_inf_nan=False)

    @classmethod
    def from_data(cls, data: Any, source: str) -> Self:
        """Build from parsed YAML; `source` is what errors call the file. Raises ConfigError, a line an error."""
        require_mapping(data, source)
        try:
            # JSON mode lets YAML lists fill tuples while numbers and strings stay strict.
            return cls.model_validate_json(_to_json(data, source))
        except ValidationError as error:
            lines = [f"{source}: {_explain(cls, item)}" for item in error.errors()]
            if len(lines) > MAX_ERRORS:
                lines[MAX_ERRORS:] = [f"{source}: and {len(lines) - MAX_ERRORS} more errors"]
            raise ConfigError("\n".join(lines)) from None

    def as_data(self) -> dict[str, Any]:
        """Plain JSON data."""
        return self.model_dump(mode="json")


def require_mapping(data: Any, source: str) -> dict[str, Any]:
    """The data, when it is a mapping of fields. Raises ConfigError that says what it is instead."""
    if isinstance(data, dict):
        return data
    found = "nothing: the file is empty" if data is None else f"a {type(data).__name__}, {short(data)}"
    raise ConfigError(f"{source}: expected a mapping of fields (`field: value` lines), found {found}")


def meant(name: Any, known: Iterable[str]) -> str:
    """What an error puts between a name that it does not know and those it does: the nearest one, or a semicolon."""
    near = get_close_matches(str(name), list(known), 1)
    return f", did you mean {near[0]}?" if near else ";"


def _to_json(data: Any, source: str) -> str:
    try:
        return json.dumps(data, allow_nan=True)
    except (TypeError, ValueError, RecursionError) as error:
        raise ConfigError(f"{source}: a value is not plain data ({error})") from None


def _explain(model: type[BaseModel], item: Any) -> str:
    """One line on one pydantic error: field, value, what is allowed."""
    kind, loc, value = item["type"], item["loc"], item["input"]
    field = ".".join(_shown(str(part)) for part in loc if part not in FORMS)
    if kind == "value_error":  # of a validator of ours, whose text gives the values it compared
        return f"{field}: {item['ctx']['error']}" if field else str(item["ctx"]["error"])
    if kind == "missing":
        return f"{field}: missing; this field has no default"
    given = f"{field} = {short(value)[:200]}" if field else "whole file"
    if kind == "extra_forbidden":
        allowed = _fields_at(model, loc[:-1])
        return f"{given}: unknown field{meant(loc[-1], allowed)} allowed: {', '.join(allowed)}"
    message = item["msg"].replace("None", "null")
    if kind in ("float_type", "int_type") and isinstance(value, str):
        message += "; this is text: write it without quotes, and an exponent as in 1.0e+6"
    return f"{given}: {message}"


def _shown(name: str) -> str:
    """The name of a field, which anybody may have chosen, as one line can hold it."""
    return name[:80] if name.isprintable() else repr(name[:80])


def _fields_at(model: type[BaseModel], loc: Sequence[str | int]) -> list[str]:
    """Names of the fields allowed at a place in a model; list indices and keys lead to the items."""
    for part in loc:
        if part in model.model_fields:
            model = _model_in(model.model_fields[str(part)].annotation) or model
    return list(model.model_fields)


def _model_in(annotation: Any) -> type[BaseModel] | None:
    """The model that an annotation such as `tuple[Leg, ...]` is made of."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((found for arg in get_args(annotation) if (found := _model_in(arg))), None)


_YAML = "tag:yaml.org,2002:"


def _number(construct: Any) -> Any:
    """A constructor of numbers, but of none in base 60, such as 1:30: long ones take minutes, or overflow a float."""

    def plain(loader: yaml.SafeLoader, node: yaml.ScalarNode) -> Any:
        if ":" in node.value:
            problem = f"{short(node.value)} is a number in base 60: write the time in quotes, or a number in base 10"
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=node.start_mark)
        return construct(loader, node)

    return plain


class _PlainLoader(yaml.SafeLoader):
    """YAML's plain data, no more: text, numbers, booleans, null, lists and mappings without repeated fields."""

    yaml_constructors: ClassVar[dict[str | None, Any]] = {
        tag: construct
        for tag, construct in yaml.SafeLoader.yaml_constructors.items()
        if tag is None or tag.removeprefix(_YAML) in ("null", "bool", "int", "float", "str", "seq", "map")
    } | {
        _YAML + "timestamp": yaml.SafeLoader.construct_yaml_str,
        _YAML + "int": _number(yaml.SafeLoader.construct_yaml_int),
        _YAML + "float": _number(yaml.SafeLoader.construct_yaml_float),
    }

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):  # some hundred bytes of nested aliases unfold to gigabytes
            alias = self.peek_event()
            raise yaml.MarkedYAMLError(problem="aliases are not allowed, write it out", problem_mark=alias.start_mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen = set()
        for key in (key for key, _ in node.value if isinstance(key, yaml.ScalarNode)):
            if key.value in seen:
                raise yaml.MarkedYAMLError(problem=f"{short(key.value)} is given twice", problem_mark=key.start_mark)
            seen.add(key.value)
        return super().construct_mapping(node, deep)


def read_bytes(path: Path, limit: int, what: str) -> bytes:
    """A whole file of at most `limit` bytes, `what` it is in words. Raises ConfigError: not readable, too large."""
    try:
        with path.open("rb") as file:
            content = file.read(limit + 1)
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror})") from None
    if len(content) > limit:
        raise ConfigError(f"{path}: more than {limit} bytes, the most {what} may have")
    return content


def read_yaml(path: Path) -> Any:
    """Parse one YAML file into plain data. Raises ConfigError when it is missing, too large or not such YAML."""
    content = read_bytes(path, MAX_CONFIG_BYTES, "a configuration")
    try:
        return yaml.load(content.decode(), _PlainLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = f"{path}, line {mark.line + 1}, column {mark.column + 1}" if mark else str(path)
        raise ConfigError(f"{place}: not valid YAML ({error.problem or error.context})") from None
    except (yaml.YAMLError, ValueError) as error:
        raise ConfigError(f"{path}: not valid YAML ({str(error).splitlines()[0]})") from None
    except RecursionError:
        raise ConfigError(f"{path}: not valid YAML (nested too deep)") from None
