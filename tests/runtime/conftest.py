"""The small real map that the tests of the artifact and of the runtime share."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

from gaitflow.artifact import Parts
from gaitflow.gaits import Pattern
from gaitflow.runtime.point import GaitSpace
from gaitflow.runtime.program import Program, derivatives

_SPEC = importlib.util.spec_from_file_location("tiny_map", Path(__file__).parents[1] / "artifact" / "tiny_map.py")
assert _SPEC is not None
assert _SPEC.loader is not None
if "tiny_map" not in sys.modules:
    sys.modules["tiny_map"] = importlib.util.module_from_spec(_SPEC)
    _SPEC.loader.exec_module(sys.modules["tiny_map"])

from tiny_map import artifact, grown, parts, preferring, pristine  # noqa: E402

__all__ = ["artifact", "grown", "parts", "preferring", "pristine"]


@pytest.fixture(scope="session")
def evaluated(parts: Parts) -> object:
    """The map's problem with its derivatives, as CasADi's function."""
    return derivatives(parts.problem.nlp)


@pytest.fixture
def program(parts: Parts, evaluated: object) -> Program:
    return Program(parts.problem.nlp, evaluated)


@pytest.fixture(scope="session")
def spaces(parts: Parts) -> dict[str, GaitSpace]:
    """The bounds that impose each gait, by its name."""
    bounds = {start.gait: parts.problem.bounds(Pattern.from_text(start.pattern)) for start in parts.starts}
    return {gait: GaitSpace(each.lower, each.upper, each.lower_rows, each.upper_rows) for gait, each in bounds.items()}
