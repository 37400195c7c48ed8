"""IPOPT's options: those that we solve with, and which of them a map may set.

The second is a closed list: others make IPOPT write files (output_file), read files (option_file_name) or load shared
libraries (hsllib), and a map is data, not code.
"""

from __future__ import annotations

from collections.abc import Mapping
from reprlib import repr as short
from typing import Any

from gaitflow.core.errors import ArtifactError

Options = dict[str, float | int | str]

# What a solver says that ended at a minimum; the first is our own interior point's word, the others are IPOPT's.
CONVERGED = ("converged", "Solve_Succeeded", "Solved_To_Acceptable_Level")

# MUMPS' ordering is pinned to AMD, so that iterates repeat from run to run. What converges does so in 20 to 60
# iterations; what has not after 110 is a restoration that creeps towards an infeasible point.
IPOPT: Options = {"mumps_pivot_order": 0, "tol": 1e-8, "constr_viol_tol": 1e-9, "max_iter": 110}
# A primal-dual start is forgotten, and moved away from its bounds, unless every one of these is small.
IPOPT_WARM: Options = IPOPT | {
    "warm_start_init_point": "yes",
    "mu_init": 1e-4,
    "warm_start_bound_push": 1e-8,
    "warm_start_bound_frac": 1e-8,
    "warm_start_slack_bound_push": 1e-8,
    "warm_start_slack_bound_frac": 1e-8,
    "warm_start_mult_bound_push": 1e-8,
}

_NUMBERS = frozenset({
    "tol", "constr_viol_tol", "dual_inf_tol", "compl_inf_tol",
    "acceptable_tol", "acceptable_constr_viol_tol", "acceptable_dual_inf_tol", "acceptable_compl_inf_tol",
    "acceptable_obj_change_tol", "max_cpu_time", "max_wall_time", "mu_init", "mu_target", "mu_min", "mu_max",
    "bound_relax_factor", "bound_push", "bound_frac", "slack_bound_push", "slack_bound_frac",
    "warm_start_bound_push", "warm_start_bound_frac", "warm_start_slack_bound_push", "warm_start_slack_bound_frac",
    "warm_start_mult_bound_push", "warm_start_mult_init_max", "nlp_scaling_max_gradient", "mumps_pivtol",
    "mumps_pivtolmax",
})  # fmt: skip
_INTEGERS = frozenset({"max_iter", "acceptable_iter", "mumps_pivot_order", "mumps_scaling", "mumps_permuting_scaling"})
_WORDS = {
    "mu_strategy": ("monotone", "adaptive"),
    "warm_start_init_point": ("yes", "no"),
    "honor_original_bounds": ("yes", "no"),
    "fixed_variable_treatment": ("make_parameter", "make_parameter_nodual", "make_constraint", "relax_bounds"),
    "nlp_scaling_method": ("none", "gradient-based"),
    "mehrotra_algorithm": ("yes", "no"),
    "expect_infeasible_problem": ("yes", "no"),
}


def checked_options(options: Mapping[str, Any]) -> Options:
    """The options, all known and of their type, without the prefix "ipopt.". Raises ArtifactError for any other."""
    return {name: _checked(name, value) for name, value in options.items()}


def _checked(name: str, value: Any) -> float | int | str:
    if name in _WORDS:
        if value in _WORDS[name]:
            return str(value)
        raise ArtifactError(f"solver.options.{name} = {short(value)}: must be one of {', '.join(_WORDS[name])}")
    if name in _INTEGERS:
        if type(value) is int and 0 <= value < 2**31:
            return value
        raise ArtifactError(f"solver.options.{name} = {short(value)}: must be an integer from 0 to {2**31 - 1}")
    if name in _NUMBERS:
        if type(value) in (int, float) and 0 <= value < 1e300:
            return float(value)
        raise ArtifactError(f"solver.options.{name} = {short(value)}: must be a finite number of at least 0")
    allowed = ", ".join(sorted({*_NUMBERS, *_INTEGERS, *_WORDS}))
    raise ArtifactError(f"solver.options.{name[:80]}: an artifact may not set this option; it may set {allowed}")
