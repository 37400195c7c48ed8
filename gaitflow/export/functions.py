"""The map's problem, its derivatives and its nominal start as C, by CasADi's code generator."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import casadi

from gaitflow.core.layout import Layout
from gaitflow.core.trajectory import Array
from gaitflow.export.nominal import nominal
from gaitflow.export.piecewise import piecewise
from gaitflow.problem import SeparableProblem
from gaitflow.solvers.program import derivatives

# What each file holds. One function for all derivatives would take a compiler minutes and gigabytes in space.
FILES = {"problem": ("problem", "gradient", "nominal"), "jacobian": ("jacobian",), "hessian": ("hessian",)}


def c_files(problem: SeparableProblem, layout: Layout, default_feet: Array, scenario: str) -> dict[str, bytes]:
    """Sources and headers by name; `problem` is the map's, and `default_feet` [legs, d] its robot's.

    Each function's name begins with the scenario's, so that a planner may link several maps; map.h declares all of
    them and gives them names that every map has. Equal problems give equal files.
    """
    prefix = identifier(scenario)
    functions = _functions(problem, prefix)
    task = casadi.SX.sym("task", problem.function.numel_in(1))
    start = nominal(layout, default_feet, task)
    functions["nominal"] = casadi.Function(f"{prefix}_nominal", [task], [casadi.densify(start)], ["task"], ["w"])
    files = {"map.h": _shared_names(prefix)}
    for name, held in FILES.items():
        files |= _generated(name, prefix, [functions[each] for each in held])
    return {name: text.encode() for name, text in files.items()}


def identifier(scenario: str) -> str:
    """A scenario's name as the begin of a C name that CasADi takes, too."""
    words = re.sub(r"[^A-Za-z0-9]+", "_", scenario).strip("_")
    return words if words[:1].isalpha() else f"map_{words}".rstrip("_")


def _functions(problem: SeparableProblem, prefix: str) -> dict[str, Any]:
    """By name: the functions of (w, task), the Hessian's of (w, task, multipliers)."""
    found = _in_one_piece(problem) if problem.pieces is None else piecewise(problem, problem.pieces)
    inputs, outputs = ("w", "task", "multipliers"), {name: (name,) for name in found} | {"problem": ("cost", "rows")}
    return {
        name: casadi.Function(f"{prefix}_{name}", *each, inputs[: len(each[0])], outputs[name])
        for name, each in found.items()
    }


def _in_one_piece(problem: SeparableProblem) -> dict[str, tuple[list[Any], list[Any]]]:
    """Inputs and results of the functions, of a problem of which nothing is known but what it computes."""
    function = derivatives(problem)
    w, task, multipliers = (casadi.SX.sym(function.name_in(i), function.numel_in(i)) for i in range(3))
    cost, rows, gradient, jacobian, hessian = function(w, task, multipliers)
    results = {"problem": [cost, rows], "gradient": [gradient], "jacobian": [jacobian], "hessian": [hessian]}
    return {
        name: ([w, task, multipliers] if name == "hessian" else [w, task], casadi.cse(result))
        for name, result in results.items()
    }


def _generated(name: str, prefix: str, functions: Sequence[Any]) -> dict[str, str]:
    # The generator derives the names of helpers from the file's, and writes the header only to a folder.
    generator = casadi.CodeGenerator(f"{prefix}_{name}.c", {"with_header": True})
    for function in functions:
        generator.add(function)
    with tempfile.TemporaryDirectory() as folder:
        generator.generate(f"{folder}/")
        return {
            f"{name}{suffix}": Path(folder, f"{prefix}_{name}{suffix}").read_text(encoding="ascii")
            for suffix in (".c", ".h")
        }


def _shared_names(prefix: str) -> str:
    includes = "".join(f'#include "{name}.h"\n' for name in FILES)
    names = [each for held in FILES.values() for each in held]
    aliases = "".join(f"#define gaitflow_{name} {prefix}_{name}\n" for name in names)
    return (
        f"/* The functions of {prefix}, and names for code that is built against one map, whichever it is. */\n"
        f"{includes}\n{aliases}"
    )
