"""Which code solves: a digest of its sources, which stored results carry."""

from __future__ import annotations

import ast
import functools
import hashlib
from collections.abc import Iterable, Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import gaitflow

SOLVER_SOURCES = (
    "problem/*.py", "solvers/*.py", "search/*.py", "config/axes.py", "config/limbs.py", "config/limits.py",
    "config/scenario.py", "config/robot.py", "core/check.py", "core/continuous.py", "core/force_rate.py",
    "core/gaits.py", "core/joints.py", "core/layout.py", "core/mesh_error.py", "core/rigid_body.py",
    "core/swing_reach.py", "core/swing_reaction.py", "core/task.py", "core/task_space.py", "core/trajectory.py",
    "core/twist.py",
)  # fmt: skip


@functools.cache
def solver_version() -> dict[str, str]:
    """Digest of the code that solves, blind to comments, layout and docstrings, and CasADi's version.

    Read once per process: it names the code that was loaded, even when the files change while a run is on.
    """
    try:
        casadi = version("casadi")
    except PackageNotFoundError:
        casadi = "none"
    return {"code": package_digest(SOLVER_SOURCES), "casadi": casadi}


def package_digest(patterns: Iterable[str]) -> str:
    """`source_digest` of the package's own files that match one of the patterns, such as "solvers/*.py"."""
    package = Path(gaitflow.__file__).parent
    files = {path for pattern in patterns for path in package.glob(pattern)}
    return source_digest({str(path.relative_to(package)): path.read_text(encoding="utf-8") for path in files})


def source_digest(sources: Mapping[str, str]) -> str:
    """SHA-256 over the syntax trees of Python sources by name, without docstrings."""
    total = hashlib.sha256()
    for name in sorted(sources):
        tree = ast.parse(sources[name], filename=name)
        for node in ast.walk(tree):
            match node:
                case ast.Module() | ast.ClassDef() | ast.FunctionDef() | ast.AsyncFunctionDef():
                    if ast.get_docstring(node, clean=False) is not None:
                        node.body = node.body[1:]
        total.update(f"{name}\0{ast.dump(tree)}\0".encode())
    return total.hexdigest()
