"""The small real map's problem with its derivatives, and scenarios to solve."""

from __future__ import annotations

import pytest
from tiny_map import parts
from to_solve import anymal, coarse, effort, solve

from gaitflow.core.gaits import Pattern
from gaitflow.publishing import Parts
from gaitflow.solvers.point import GaitSpace
from gaitflow.solvers.program import Program, derivatives

__all__ = ["anymal", "coarse", "effort", "parts", "solve"]


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
