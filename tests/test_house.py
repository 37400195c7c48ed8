"""The promises of the repository itself: pins, links, versions, sizes, and what each install pulls in."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import gaitflow
from gaitflow.files import sha256_file

MEGABYTE = 1_000_000
# Imported by nothing, run as a program.
PROGRAMS = {"snakemake"}
# Names that only their author understood; say what a thing is instead.
PRIVATE_NAMES = {"ALWAYS", "HUNG", "LOOK_S", "NEVER", "QUICK", "STILL", "WORTH"}
PRIVATE_MODULES = {"checked", "older_tables", "paper_way", "vanished"}
# What a planner imports; the rest of the package belongs to map makers.
THIN = ("core/", "motion/", "runtime/", "solvers/")
# The extras that a part of the package may count on, beside the base install.
EXTRAS = {
    "problem/": ("solve",),
    "solvers/": ("solve",),
    "search/": ("solve",),
    "config/": ("solve",),
    "tables/": ("solve", "workflow"),
    "store/": ("solve", "workflow"),
    "dataset/": ("solve", "workflow"),
    "execute/": ("solve", "workflow"),
    "export/": ("solve", "learn"),
    "atlas/": ("solve", "learn"),
    "learn/": ("solve", "learn", "mlp"),
    "report/": ("solve", "workflow", "report"),
    "urdf/": ("robots",),
    "clients/": ("clients",),
}


@pytest.fixture(scope="module")
def tracked(checkout: Path) -> list[Path]:
    listing = subprocess.run(["git", "ls-files", "-z"], cwd=checkout, capture_output=True, text=True, check=False)
    if listing.returncode:
        pytest.skip("not a git checkout")
    return [checkout / name for name in listing.stdout.split("\0") if name and (checkout / name).is_file()]


@pytest.fixture(scope="module")
def project(checkout: Path) -> dict[str, list[Requirement]]:
    """Requirements by extra, "" for the base install; without `maps` and `all`, which only name others."""
    data = tomllib.loads((checkout / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    groups = {"": data["dependencies"]} | data["optional-dependencies"]
    return {
        name: [Requirement(text) for text in group] for name, group in groups.items() if name not in ("maps", "all")
    }


def _names(requirements: list[Requirement]) -> set[str]:
    return {canonicalize_name(requirement.name) for requirement in requirements}


@cache
def _owners() -> Mapping[str, list[str]]:
    """Distributions by the module they install; slow to find out.

    pin's modules lie below a prefix of their own, mujoco's in a distribution that it brings along.
    """
    return {**packages_distributions(), "pinocchio": ["pin"], "mujoco": ["mujoco"]}


def _third_party_imports(file: Path) -> set[str]:
    """Distributions that the module imports anywhere, also inside functions; the standard library left out."""
    modules: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            modules.update(alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            modules.add(node.module.split(".")[0])
    owners = _owners()
    modules -= set(sys.stdlib_module_names) | {"gaitflow", "benchmarks"}
    return {canonicalize_name(owners.get(module, [module])[0]) for module in modules}


def _imports_of_package(checkout: Path) -> dict[str, set[str]]:
    root = checkout / "gaitflow"
    return {file.relative_to(root).as_posix(): _third_party_imports(file) for file in sorted(root.rglob("*.py"))}


def _constraints(checkout: Path) -> dict[str, str]:
    lines = (checkout / "constraints.txt").read_text(encoding="utf-8").splitlines()
    bad = [line for line in lines if not re.fullmatch(r"[A-Za-z0-9._-]+==[A-Za-z0-9.]+", line)]
    assert not bad, f"constraints.txt holds lines `name==version` only, no addresses or local builds: {bad}"
    return {canonicalize_name(name): version for name, version in (line.split("==") for line in lines)}


def test_constraints_pin_every_requirement_within_its_bounds(
    checkout: Path, project: dict[str, list[Requirement]]
) -> None:
    pins = _constraints(checkout)
    for requirement in (requirement for group in project.values() for requirement in group):
        version = pins.get(canonicalize_name(requirement.name))
        assert version is not None, f"{requirement.name} is not in constraints.txt: run `make constraints`"
        assert version in requirement.specifier, f"constraints.txt pins {requirement.name} to {version}: {requirement}"


def test_base_install_is_what_the_thin_modules_import(checkout: Path, project: dict[str, list[Requirement]]) -> None:
    base = _names(project[""])
    thin = {name: found for name, found in _imports_of_package(checkout).items() if name.startswith(THIN)}
    assert thin
    planning = _imports_for_planning(checkout)
    for name, found in thin.items():
        allowed = base | planning.get(name, set())
        assert found <= allowed, f"gaitflow/{name} imports {sorted(found - allowed)}, not in the base install"


def _imports_for_planning(checkout: Path) -> dict[str, set[str]]:
    """What thin modules import only inside functions that plan: the exceptions of import-linter's first contract."""
    data = tomllib.loads((checkout / "pyproject.toml").read_text(encoding="utf-8"))
    exceptions = data["tool"]["importlinter"]["contracts"][0]["ignore_imports"]
    found: dict[str, set[str]] = {}
    for module, _, library in (line.partition(" -> ") for line in exceptions):
        name = module.removeprefix("gaitflow.").replace(".", "/") + ".py"
        found.setdefault(name, set()).add(library)
    return found


def test_each_part_imports_what_its_extras_install(checkout: Path, project: dict[str, list[Requirement]]) -> None:
    imports = _imports_of_package(checkout)
    for part, extras in EXTRAS.items():
        installed = set().union(*(_names(project[extra]) for extra in ("", *extras)))
        files = {name: found - installed for name, found in imports.items() if name.startswith(part)}
        assert files
        assert not {name: missing for name, missing in files.items() if missing}, f"not in {extras}"


def test_every_import_is_declared_and_every_declared_library_is_used(
    checkout: Path, project: dict[str, list[Requirement]]
) -> None:
    declared = set().union(*(_names(group) for extra, group in project.items() if extra != "dev"))
    imported = set().union(*_imports_of_package(checkout).values())
    undeclared, unused = imported - declared, declared - imported - PROGRAMS
    assert not undeclared, "imported, in no extra of pyproject.toml"
    assert not unused, "in pyproject.toml, imported nowhere"


def test_links_of_every_page_lead_somewhere(checkout: Path, tracked: list[Path]) -> None:
    broken = []
    for page in (file for file in tracked if file.suffix == ".md"):
        prose = re.sub(r"```.*?```|`[^`\n]*`", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
        for target in re.findall(r"\]\(<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\)", prose):
            path, _, anchor = target.partition("#")
            if re.match(r"[a-z][a-z0-9+.-]*:", path):
                continue
            file = (page.parent / path).resolve() if path else page
            if not file.exists() or not file.is_relative_to(checkout) or (anchor and anchor not in _anchors(file)):
                broken.append(f"{page.relative_to(checkout)} -> {target}")
    assert not broken


def _anchors(page: Path) -> set[str]:
    headings = re.findall(r"^#+\s+(.+?)\s*$", page.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_version_is_the_same_everywhere(checkout: Path) -> None:
    citation = yaml.safe_load((checkout / "CITATION.cff").read_text(encoding="utf-8"))
    assert str(citation["version"]) == gaitflow.__version__
    changelog = (checkout / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"## [{gaitflow.__version__}]" in changelog


def test_no_tracked_file_is_large(tracked: list[Path]) -> None:
    large = {str(file): file.stat().st_size for file in tracked if file.stat().st_size > 20 * MEGABYTE}
    assert not large, "published results stay below 20 MB a file"


def test_no_tracked_file_names_a_path_of_one_machine(checkout: Path, tracked: list[Path]) -> None:
    # It begins with the slash, for which Python looks fast: the published files have hundreds of megabytes.
    here = re.escape(str(checkout).encode().removeprefix(b"/"))
    private = re.compile(rb"/(?:(?<![\w.$}>-]/)(?:home|root|Users|work)/\w|" + here + rb"\b)")
    found = [
        f"{file.relative_to(checkout)}: {hit.group().decode(errors='replace')}"
        for file in tracked
        if (hit := private.search(file.read_bytes()))
    ]
    assert not found


def test_ci_scripts_can_be_run(checkout: Path, tracked: list[Path]) -> None:
    scripts = [file for file in tracked if file.parent == checkout / ".ci"]
    assert checkout / ".ci" / "run" in scripts
    for script in scripts:
        mode = subprocess.run(
            ["git", "ls-files", "--stage", str(script)], cwd=checkout, capture_output=True, text=True, check=True
        ).stdout[:6]
        assert mode == "100755", f"{script.name} is not executable: git update-index --chmod=+x"
        subprocess.run(["bash", "-n", str(script)], check=True)


def test_names_are_the_fields(checkout: Path) -> None:
    private = []
    for file in (*(checkout / "gaitflow").rglob("*.py"), *(checkout / "benchmarks").rglob("*.py")):
        name = file.relative_to(checkout).as_posix()
        if file.stem in PRIVATE_MODULES:
            private.append(name)
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Name) and node.id.strip("_") in PRIVATE_NAMES:
                private.append(f"{name}:{node.lineno} {node.id}")
    assert not private, "one name for one thing, in the words of the field"


def test_no_published_data_stand_twice(checkout: Path, tracked: list[Path]) -> None:
    files = [file for file in tracked if file.is_relative_to(checkout / "datasets") and file.suffix == ".parquet"]
    assert files
    by_content: dict[str, list[str]] = {}
    for file in files:
        by_content.setdefault(sha256_file(file), []).append(str(file.relative_to(checkout)))
    assert not [names for names in by_content.values() if len(names) > 1], "a dataset has versions of its own"
