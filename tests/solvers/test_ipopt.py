from __future__ import annotations

import numpy as np
import pytest
from tasks_at import at
from to_solve import Solve, nominal

from gaitflow.config.scenario import Scenario, Transcription
from gaitflow.core.gaits import Pattern
from gaitflow.problem import Bounds, GaitProblem, transcribe
from gaitflow.solvers.ipopt import call_solver, make_ipopt, symbolic
from gaitflow.solvers.options import CONVERGED, IPOPT

PATTERN, TASK = Pattern.from_text("0110/1100"), at(0.9, 0.6)


def arguments(problem: GaitProblem, bounds: Bounds, start: np.ndarray) -> dict:
    return {
        "x0": start, "p": TASK.parameters, "lbx": bounds.lower, "ubx": bounds.upper,
        "lbg": bounds.lower_rows, "ubg": bounds.upper_rows,
    }  # fmt: skip


def test_the_expressions_are_the_programs(problem: GaitProblem) -> None:
    import casadi as ca

    found = symbolic(problem.nlp)
    again = ca.Function("again", [found["x"], found["p"]], [found["f"], found["g"]])
    w = nominal(problem, TASK).w
    for one, other in zip(again(w, TASK.parameters), problem.nlp(w, TASK.parameters), strict=True):
        np.testing.assert_array_equal(one.full(), other.full())


def test_an_exception_is_a_status_and_the_start_comes_back(problem: GaitProblem) -> None:
    """CasADi throws on bounds that contradict."""
    bounds, start = problem.bounds(PATTERN), nominal(problem, TASK).w
    swapped = Bounds(bounds.upper, bounds.lower, bounds.lower_rows, bounds.upper_rows)
    status, iterations, result = call_solver(make_ipopt(problem.nlp, IPOPT), arguments(problem, swapped, start))
    assert status.startswith("exception: ")
    assert iterations == 0
    np.testing.assert_array_equal(result["x"], start)
    assert np.isnan(result["f"]).all()
    assert result["lam_g"].shape == (problem.ng,) and not result["lam_g"].any()


def test_its_options_are_heard(problem: GaitProblem) -> None:
    solver = make_ipopt(problem.nlp, IPOPT | {"max_iter": 3})
    start = nominal(problem, TASK).w
    status, iterations, _ = call_solver(solver, arguments(problem, problem.bounds(PATTERN), start))
    assert (status, iterations) == ("Maximum_Iterations_Exceeded", 3)


@pytest.mark.parametrize(("text", "speed", "cycle"), [("0110/1100", 0.9, 0.6), ("0001/0100", 1.0, 0.8)])
def test_the_big_m_form_with_fixed_contacts_has_the_same_optimum(
    effort: Scenario, solve: Solve, text: str, speed: float, cycle: float
) -> None:
    """The paper's fixed-gait problem and ours differ in how a solver sees them, not in what they say."""
    scenario = effort.model_copy(update={"transcription": Transcription(knots_per_phase=5)})
    problem = transcribe(scenario)
    pattern, task = Pattern.from_text(text), at(speed, cycle)
    contacts = [float(digit) for row in pattern.rows for digit in row]
    start = np.append(nominal(problem, task).w, contacts)
    patient = IPOPT | {"max_iter": 1000}  # this form takes several times as many iterations
    given = arguments(problem, problem.minlp_bounds(pattern), start) | {"p": task.parameters}
    status, _, result = call_solver(make_ipopt(problem.minlp, patient), given)
    assert status in CONVERGED
    ours = solve(scenario, text, speed, cycle)
    assert float(result["f"][0]) * problem.cost_scale == pytest.approx(ours.cost, rel=1e-5)
