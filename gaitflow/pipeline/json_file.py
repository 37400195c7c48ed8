"""The stages' own JSON files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from gaitflow.files import atomic_write


def write_json(path: Path, data: Any) -> None:
    """Write plain data as JSON, whole or not at all."""
    atomic_write(path, (json.dumps(data, indent=1, allow_nan=False) + "\n").encode())


def read_json(path: Path) -> Any:
    """Read a JSON file of ours."""
    return json.loads(path.read_bytes())
