"""Base of every configuration model: strict, frozen, unknown fields refused, errors in one line."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Self

import yaml
from pydantic import BaseModel, ConfigDict, ValidationError

MAX_CONFIG_BYTES = 1_000_000


class ConfigError(ValueError):
    """A configuration file that cannot be used: names the file, the field, the value and what is allowed."""


class Config(BaseModel):
    """Frozen, strict data: nothing is coerced but int to float, nothing unknown is let through."""

    model_config = ConfigDict(frozen=True, strict=True, extra="forbid", allow_inf_nan=False)

    @classmethod
    def from_data(cls, data: Any, source: str) -> Self:
        """Build from parsed YAML; `source` is what errors call the file. Raises ConfigError."""
        if not isinstance(data, dict):
            raise ConfigError(f"{source}: expected a mapping of fields, found {type(data).__name__}")
        try:
            # JSON mode lets YAML lists fill tuples while numbers and strings stay strict.
            return cls.model_validate_json(_to_json(data, source))
        except ValidationError as error:
            raise ConfigError("\n".join(_explain(source, item) for item in error.errors())) from None

    def as_data(self) -> dict[str, Any]:
        """Plain JSON data."""
        return self.model_dump(mode="json")


def _to_json(data: Any, source: str) -> str:
    import json

    try:
        return json.dumps(data, allow_nan=True)
    except (TypeError, ValueError) as error:
        raise ConfigError(f"{source}: a value is not plain data ({error})") from None


def _explain(source: str, item: Any) -> str:
    field = ".".join(str(part) for part in item["loc"]) or "(whole file)"
    value = "" if item["type"] == "missing" else f" = {item['input']!r}"
    if item["type"] == "extra_forbidden":
        return f"{source}: {field}{value}: unknown field; check its spelling or delete it"
    return f"{source}: {field}{value}: {item['msg']}"


def read_yaml(path: Path) -> Any:
    """Parse one YAML file safely. Raises ConfigError when it is missing, too large or not YAML."""
    try:
        size = path.stat().st_size
        if size > MAX_CONFIG_BYTES:
            raise ConfigError(f"{path}: {size} bytes; a configuration has at most {MAX_CONFIG_BYTES}")
        return yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror})") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: not valid YAML ({str(error).splitlines()[0]})") from None
