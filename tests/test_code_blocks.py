"""Every code block of the README and of docs/ works: Python runs, commands run or parse, YAML loads, C++ compiles."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import click
import pytest
import yaml
from click.testing import CliRunner
from code_blocks import blocks_of, code_of, shell_lines

from gaitflow.cli import main
from gaitflow.config.cluster import Profile
from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.config.sweep import Sweep, sampled
from gaitflow.pipeline.workspace import Workspace

ROOT = Path(__file__).resolve().parent.parent
PAGES = {
    path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
    for path in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
}
LANGUAGES = {"bash", "cmake", "cpp", "python", "text", "yaml"}  # text: formulas and the trees of folders
TUTORIAL = "docs/your-own-robot.md"  # test_tutorial.py runs all of it

# What must hold after the Python of a page has run.
HOLDS = {
    "README.md": "choice.in_domain and plan.feasible",
    "docs/clients.md": "record.walked and not walker.fallen and all(found.ready for found in shots + predictions)",
    "docs/data-format.md": "feet.shape[2:] == (2, 2) and record['scenario']",
    "docs/motion.md": "states.contact[[0, -1]].all() and frames.base_link and Path('change.info').stat().st_size",
    "docs/runtime.md": "choice.in_domain and plan.feasible",
}
SLOW = {"docs/clients.md", "docs/gallery.md"}  # a simulation, whole-body optimisation, eight pictures

# Commands that are parsed with their options and arguments, and not run.
PARSED = {
    "cancel": "needs Slurm",
    "certify": "searches for minutes",
    "compact": "needs a run",
    "datasets publish": "needs a run",
    "doctor": "needs Slurm",
    "drive": "a simulation of a minute",
    "estimate": "solves",
    "export": "the test of C++ runs it",
    "paper": "draws for minutes",
    "report": "draws for minutes",
    "robot import": "needs a URDF of the reader's; the tutorial imports one",
    "run": "solves",
    "solve": "solves",
    "status": "needs a run",
    "submit": "needs Slurm",
    "sweep": "solves",
    "walk": "a simulation; the Python of the page runs one",
}
OTHER_PROGRAMS = {
    "apptainer": "needs an image",
    "docker": "needs an image",
    ".venv/bin/python": "builds a wheel, as CI does",
    "cmake": "the test of C++ runs it",
    "echo": "the test of C++ runs it",
    "python": "tests/examples run it",
    "build/loop": "the test of C++ runs it",
}


@pytest.fixture
def workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder, now the current one, with what the pages name: maps, datasets and scenarios."""
    for name in ("datasets", "docs", "examples", "models", "slurm"):
        (tmp_path / name).symlink_to(ROOT / name)
    shutil.copytree(ROOT / "configs", tmp_path / "configs")
    for code in code_of(PAGES["README.md"], "yaml"):
        (tmp_path / f"configs/scenarios/{yaml.safe_load(code)['name']}.yaml").write_text(code, encoding="utf-8")
    (tmp_path / "my_robot.urdf").touch()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def marked(page: str, *others: str) -> object:
    """Arguments of a test that is slow where the page is."""
    return pytest.param(page, *others, marks=[pytest.mark.slow] if page in SLOW else [])


def ran(command: list[str], folder: Path) -> str:
    paths = {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=folder, env=os.environ | paths, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("page", PAGES)
def test_every_block_is_in_a_language_that_is_tested(page: str) -> None:
    unknown = [block for block in blocks_of(PAGES[page]) if block.language not in LANGUAGES]
    assert not unknown, f"name one of {sorted(LANGUAGES)} after the three backticks"


@pytest.mark.parametrize("page", [marked(page) for page in HOLDS])
def test_the_python_of_a_page_runs(page: str, workspace: Path) -> None:
    ran([sys.executable, "-c", "\n".join([*code_of(PAGES[page], "python"), f"assert {HOLDS[page]}"])], workspace)


def test_no_page_with_python_is_left_out() -> None:
    assert {page for page in PAGES if code_of(PAGES[page], "python")} == set(HOLDS)


def command_of(words: list[str]) -> tuple[str, click.Command, list[str]]:
    """Name, command and arguments of a `gaitflow ...` line."""
    command: click.Command = main
    names, rest = [], words[1:]
    while isinstance(command, click.Group):
        assert rest and rest[0] in command.commands, f"{shlex.join(words)}: no such command"
        names.append(rest[0])
        command, rest = command.commands[rest[0]], rest[1:]
    return " ".join(names), command, rest


LINES = [(page, line) for page in PAGES if page != TUTORIAL for line in shell_lines(PAGES[page])]


@pytest.mark.parametrize(("page", "line"), [marked(*each) for each in LINES])
def test_a_shell_line_works(page: str, line: str, workspace: Path) -> None:
    words = shlex.split(line, comments=True)
    if words[0] == "gaitflow":
        name, command, rest = command_of(words)
        if name in PARSED:
            assert command.make_context(name, rest, parent=click.Context(main, obj=Workspace(workspace)))
        else:
            done = CliRunner().invoke(main, words[1:])
            assert done.exit_code == 0, done.output
    elif words[:2] == ["pip", "install"]:
        extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"][
            "optional-dependencies"
        ]
        asked = re.fullmatch(r"(?:gaitflow|\.)(?:\[(.+)\])?", words[2])
        assert asked and set((asked[1] or "maps").split(",")) <= set(extras)
    else:
        assert words[0] in OTHER_PROGRAMS


def test_what_is_not_run_is_on_a_page() -> None:
    words = [shlex.split(line, comments=True) for _, line in LINES]
    assert {command_of(each)[0] for each in words if each[0] == "gaitflow"} >= set(PARSED)
    assert {each[0] for each in words} == {"gaitflow", "pip", *OTHER_PROGRAMS}


YAML = [(page, code) for page in PAGES for code in code_of(PAGES[page], "yaml")]


@pytest.mark.parametrize(("page", "code"), YAML)
def test_yaml_is_a_scenario_a_sweep_or_a_profile_or_a_part_of_one(page: str, code: str, workspace: Path) -> None:
    data = yaml.safe_load(code)
    if set(data) <= set(Profile.model_fields):
        profile = yaml.safe_load((ROOT / "slurm/profiles/centre-48h.yaml").read_text(encoding="utf-8"))
        assert Profile.from_data(profile | data, page)
    elif "ranges" in data:
        assert sampled(Workspace(workspace).scenario("half-cheetah-exact-effort"), Sweep.from_data(data, page))
    else:
        assert set(data) <= set(Scenario.model_fields)
        whole = yaml.safe_load((ROOT / "configs/scenarios/half-cheetah-exact-effort.yaml").read_text(encoding="utf-8"))
        file = workspace / "configs/scenarios/of-the-page.yaml"
        file.write_text(code if "name" in data else yaml.safe_dump(whole | data), encoding="utf-8")
        assert load_scenario(file).tasks.ranges


@pytest.mark.slow
@pytest.mark.timeout(600)  # it compiles a map twice
def test_the_cpp_and_its_commands_work(workspace: Path) -> None:
    page = PAGES["docs/other-languages.md"]
    assert ran(["bash", "-euo", "pipefail", "-c", "\n".join(code_of(page, "bash"))], workspace)
    includes, statements = [], []
    for code in code_of(page, "cpp"):
        includes += [line for line in code.splitlines() if line.startswith("#include")]
        # A block may use what those above it made, and make it anew.
        statements += ["{", *(line for line in code.splitlines() if not line.startswith("#include"))]
    project = workspace / "planner"
    project.mkdir()
    use = "template <class... T> void use(const std::string& gait, const T&...) { std::cout << gait; }"
    lines = ["#include <iostream>", *includes, use, "int main() {", *statements, "}" * statements.count("{"), "}"]
    (project / "planner.cpp").write_text("\n".join(lines), encoding="utf-8")
    head = "cmake_minimum_required(VERSION 3.16)\nproject(planner C CXX)\nadd_executable(my_planner planner.cpp)\n"
    (project / "CMakeLists.txt").write_text(head + "".join(code_of(page, "cmake")), encoding="utf-8")
    export = workspace / "half-cheetah-c"
    ran(["cmake", "-S", str(project), "-B", str(project / "build"), f"-Dgaitflow_map_DIR={export}"], workspace)
    ran(["cmake", "--build", str(project / "build")], workspace)
    assert ran([str(project / "build" / "my_planner")], export) == "walking"
