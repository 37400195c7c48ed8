"""Derivatives with elements: those of the problem as one function, and nothing of copies behind a shut gate."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from gaitflow.config.scenario import load_scenario
from gaitflow.core.gaits import Pattern
from gaitflow.core.task import AXES
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.problem.separable import Element, SeparableProblem
from gaitflow.search import starts
from gaitflow.solvers.program import derivatives

NOTHING = np.zeros(len(AXES))


def whole(problem: SeparableProblem) -> ca.Function:
    """The derivatives of the problem as one function."""
    return derivatives(SeparableProblem(problem.function))


@pytest.fixture(scope="module")
def energy(checkout: Path) -> GaitProblem:
    """ANYmal by least energy, 4 knots a phase."""
    scenario = load_scenario(checkout / "configs/scenarios/anymal-energy.yaml")
    coarse = scenario.transcription.model_copy(update={"knots_per_phase": 4})
    return transcribe(scenario.model_copy(update={"transcription": coarse}))


@pytest.mark.parametrize("pattern", ["0011/1100/1100/0011", "1110/1011/1101/0111"])
def test_energy_is_derived_as_in_one_piece_where_a_gait_is_free(energy: GaitProblem, pattern: str) -> None:
    rng = np.random.default_rng(4)
    scenario, layout, bounds = energy.scenario, energy.layout, energy.bounds(Pattern.from_text(pattern))
    task = scenario.tasks.space.task({"speed": 0.7, "cycle_duration": 0.6})
    start = starts.nominal(scenario.robot, layout, task)
    w = np.clip(start + 0.02 * rng.normal(size=layout.nw), bounds.lower, bounds.upper)
    multipliers = rng.normal(size=energy.ng)
    found, expected = (
        each(w, task.parameters, multipliers) for each in (derivatives(energy.separable), whole(energy.separable))
    )
    free = np.flatnonzero(bounds.lower < bounds.upper)
    for name, one, other in zip(("cost", "rows", "gradient", "jacobian", "hessian"), found, expected, strict=True):
        mine, theirs = one.full(), other.full()
        if name in ("gradient", "hessian"):
            mine, theirs = mine[free], theirs[free]
        if name == "hessian":
            mine, theirs = mine[:, free], theirs[:, free]
        np.testing.assert_allclose(mine, theirs, rtol=1e-9, atol=1e-9 * np.abs(theirs).max(), err_msg=name)


def test_a_shut_gate_leaves_a_copy_out_of_derivatives_alone() -> None:
    w, task = ca.SX.sym("w", 4), ca.SX.sym("task", len(AXES))
    rest = ca.Function("rest", [w, task], [ca.sumsqr(w), w[:2]])
    element = Element.chained(
        (lambda x, _: x[0] * x[1] ** 2,), np.array([[0, 1], [3, 2]]), np.array([1.0, 3.0]), np.array([2, 3])
    )
    point, multipliers = np.array([1.0, 2.0, 0.0, 5.0]), np.zeros(2)
    gated, open_ = SeparableProblem(rest, (element,)), SeparableProblem(rest, (replace(element, gates=None),))
    shut = derivatives(gated)(point, NOTHING, multipliers)
    every = derivatives(open_)(point, NOTHING, multipliers)
    assert float(shut[0]) == float(every[0]) == pytest.approx(point @ point + 4.0)
    np.testing.assert_allclose(shut[2].full().ravel(), 2 * point + [0, 0, 0, 0])
    np.testing.assert_allclose(every[2].full().ravel(), 2 * point + [4, 4, 0, 0])
    assert shut[4].full()[0, 1] == 0.0 and every[4].full()[0, 1] == 4.0
    assert shut[4].full()[2, 3] == every[4].full()[2, 3] == 0.0, "2 * 3 * w[2]"
    assert every[4].full()[2, 2] == shut[4].full()[2, 2] == 2.0 + 30.0
