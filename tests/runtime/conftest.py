"""The small real map that the tests of the artifact and of the runtime share."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

_SPEC = importlib.util.spec_from_file_location("tiny_map", Path(__file__).parents[1] / "artifact" / "tiny_map.py")
assert _SPEC is not None
assert _SPEC.loader is not None
if "tiny_map" not in sys.modules:
    sys.modules["tiny_map"] = importlib.util.module_from_spec(_SPEC)
    _SPEC.loader.exec_module(sys.modules["tiny_map"])

from tiny_map import artifact, grown, parts, preferring, pristine  # noqa: E402

__all__ = ["artifact", "grown", "parts", "preferring", "pristine"]
