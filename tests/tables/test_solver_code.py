from __future__ import annotations

from pathlib import Path

import pytest
from loaded_modules import loaded_by

import gaitflow
from gaitflow.tables import solver_code as module
from gaitflow.tables.solver_code import source_digest


def test_code_digest_is_blind_to_comments_and_docstrings_only() -> None:
    code = 'def f(x):\n    """Doc."""\n    return x + 1\n'
    prose = '"""Module."""\n# why\n\ndef f(x):\n    """Other."""\n    return (x + 1)\n'
    assert source_digest({"a.py": code}) == source_digest({"a.py": prose})
    assert source_digest({"a.py": code}) != source_digest({"a.py": code.replace("1", "2")})
    assert source_digest({"a.py": code}) != source_digest({"b.py": code})


def test_code_version_reads_the_solving_code(monkeypatch: pytest.MonkeyPatch) -> None:
    before = module.solver_version.__wrapped__()
    monkeypatch.setattr(module, "SOLVER_SOURCES", ("core/gaits.py",))
    assert before["casadi"] and module.solver_version.__wrapped__()["code"] != before["code"]


# Of what is loaded with the solver these decide no number: where files are, how they are read and written, and what
# gaits and links are called.
DECIDES_NOTHING = {
    "gaitflow", "gaitflow.config", "gaitflow.config.file", "gaitflow.config.frames", "gaitflow.config.sampling",
    "gaitflow.core", "gaitflow.core.errors", "gaitflow.core.names", "gaitflow.shipped",
}  # fmt: skip


def test_code_version_covers_every_module_that_solves() -> None:
    code = (
        "import pkgutil, importlib, gaitflow.search, gaitflow.solvers\n"
        "for package in (gaitflow.search, gaitflow.solvers):\n"
        "    for module in pkgutil.iter_modules(package.__path__):\n"
        "        importlib.import_module(f'{package.__name__}.{module.name}')\n"
    )
    loaded = loaded_by(code)
    package = Path(gaitflow.__file__).parent
    covered = {path for pattern in module.SOLVER_SOURCES for path in package.glob(pattern)}
    assert "gaitflow.solvers.interior_point" in loaded
    assert {name for name, file in loaded.items() if file not in covered} == DECIDES_NOTHING
