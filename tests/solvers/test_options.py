from __future__ import annotations

import casadi as ca
import pytest

from gaitflow.core.errors import ArtifactError
from gaitflow.solvers.options import _INTEGERS, _NUMBERS, _WORDS, CONVERGED, IPOPT, IPOPT_WARM, checked_options


@pytest.mark.parametrize("options", [IPOPT, IPOPT_WARM])
def test_what_we_solve_with_may_be_published(options: dict) -> None:
    assert checked_options(options) == options


def test_a_warm_start_differs_only_in_not_forgetting_it() -> None:
    assert {name: IPOPT_WARM[name] for name in IPOPT} == IPOPT
    assert all(name.startswith(("warm_start_", "mu_init")) for name in set(IPOPT_WARM) - set(IPOPT))


def test_the_first_word_of_convergence_is_our_own() -> None:
    assert CONVERGED == ("converged", "Solve_Succeeded", "Solved_To_Acceptable_Level")


@pytest.mark.parametrize(
    "name", ["output_file", "option_file_name", "hsllib", "pardisolib", "linear_solver", "print_level", "", "x" * 9999]
)
def test_options_that_reach_outside_are_refused(name: str) -> None:
    with pytest.raises(ArtifactError, match="may not set this option"):
        checked_options({name: "x"})


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("tol", "1e-8"),
        ("tol", -1.0),
        ("tol", float("inf")),
        ("tol", 10**400),
        ("tol", None),
        ("max_iter", 10.0),
        ("max_iter", True),
        ("max_iter", 2**31),
        ("mu_strategy", "fast"),
        ("mu_strategy", ["adaptive"]),
        ("warm_start_init_point", True),
    ],
)
def test_values_of_another_kind_are_refused(name: str, value: object) -> None:
    with pytest.raises(ArtifactError, match=rf"solver\.options\.{name} = .*: must be"):
        checked_options({name: value})


def test_every_allowed_option_is_one_of_ipopts() -> None:
    """IPOPT refuses an option that it does not know: a misspelt entry of the list would only show in a plan."""
    options = (
        dict.fromkeys(_NUMBERS, 0.5) | dict.fromkeys(_INTEGERS, 1) | {name: words[0] for name, words in _WORDS.items()}
    )
    x = ca.SX.sym("x")
    for name, value in options.items():
        ipopt = {"print_level": 0, "sb": "yes", name: value}
        solver = ca.nlpsol("s", "ipopt", {"x": x, "f": x**2}, {"ipopt": ipopt, "print_time": False})
        solver(x0=1.0)
        assert solver.stats()["return_status"] != "Invalid_Option", name
