"""The pages say what there is: commands and their options, scenarios, benches, nothing left open."""

from __future__ import annotations

import re
import shlex
import subprocess
from pathlib import Path

import click
import pytest

import gaitflow.runtime
from gaitflow.cli import main
from gaitflow.cli.bench import BENCHES
from gaitflow.config.scenario import load_scenario

README_LINES = 120
WIDTH = 120
# What the placeholders of the pages stand for; anything else is a name of something that exists.
PLACEHOLDERS = {"SCENARIO", "SWEEP", "NAME", "MODEL", "MAP", "DATASET", "FILE", "COMMAND", "DIR", "my-scenario"}
COMMAND = re.compile(r"^ {4}(gaitflow .*)$|`(gaitflow [a-z][^`\\]*)`", re.MULTILINE)
TUTORIAL = "docs/your-own-robot.md"  # makes its own scenario; test_tutorial.py runs all of it
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


@pytest.fixture(scope="module")
def pages(checkout: Path) -> dict[str, str]:
    """Pages written by hand, by their path: published folders have cards of their own, which never change."""
    listing = subprocess.run(
        ["git", "ls-files", "-z", "*.md"], cwd=checkout, capture_output=True, text=True, check=True
    )
    names = [name for name in listing.stdout.split("\0") if name and not re.match(r"(datasets|models)/.*/", name)]
    return {name: (checkout / name).read_text(encoding="utf-8") for name in names if (checkout / name).is_file()}


def commands_of(page: str) -> list[list[str]]:
    """Each `gaitflow ...` of a page as words, comments cut off."""
    return [shlex.split(block or inline, comments=True) for block, inline in COMMAND.findall(page)]


def fault_of(words: list[str], checkout: Path) -> str | None:
    """What a command line names that does not exist; a line that only names a command is fine."""
    command: click.Command = main
    rest = words[1:]
    while isinstance(command, click.Group) and rest and not rest[0].startswith("-"):
        if rest[0] in PLACEHOLDERS:
            return None
        if rest[0] not in command.commands:
            return f"no command {rest[0]}"
        command, rest = command.commands[rest[0]], rest[1:]
    options = {name for each in command.params if isinstance(each, click.Option) for name in each.opts} | {"--help"}
    for word in rest:
        if word.startswith("--") and word not in options and word.strip("-").upper() != "AXIS":
            return f"no option {word}"
    argument = rest[0] if rest and not rest[0].startswith(("-", "[")) else None
    if argument is None or argument in PLACEHOLDERS:
        return None
    if command.name == "bench" and argument not in BENCHES:
        return f"no bench {argument}"
    takes = {each.name for each in command.params if isinstance(each, click.Argument)}
    folder = argument.startswith(("models/", "datasets/"))  # of which `report` takes one in a scenario's place
    if folder and not (checkout / argument).is_dir() and argument.split("/")[1] not in ("quickstart", *PLACEHOLDERS):
        return f"no folder {argument}"
    if "scenario" in takes and not folder and not (checkout / f"configs/scenarios/{argument}.yaml").is_file():
        return f"no scenario {argument}"
    return None


def test_commands_of_every_page_exist(pages: dict[str, str], checkout: Path) -> None:
    lines = [(name, words) for name, page in pages.items() if name != TUTORIAL for words in commands_of(page)]
    assert len(lines) > 60
    faults = {f"{name}: {' '.join(words)}": fault_of(words, checkout) for name, words in lines}
    assert not {line: fault for line, fault in faults.items() if fault}


def test_the_readme_is_short_and_its_examples_are_true(pages: dict[str, str], checkout: Path, tmp_path: Path) -> None:
    readme = pages["README.md"]
    assert len(readme.splitlines()) <= README_LINES
    blocks = BLOCK.findall(readme)
    assert [kind for kind, _ in blocks] == ["python", "yaml"]
    file = tmp_path / "scenario.yaml"
    file.write_text(blocks[1][1], encoding="utf-8")
    assert load_scenario(file, checkout / "configs/robots").tasks.ranges
    paths = re.findall(r"(?<![\w/.])(?:models|datasets|configs|docs|examples|slurm)/[\w./-]*\w", readme)
    assert len(paths) > 20
    assert not [path for path in paths if not (checkout / path).exists() and "NAME" not in path]


def test_the_api_page_lists_what_the_runtime_offers(pages: dict[str, str]) -> None:
    assert sorted(re.findall(r"^::: gaitflow\.runtime\.(\w+)$", pages["docs/api.md"], re.MULTILINE)) == sorted(
        gaitflow.runtime.__all__
    )


def test_nothing_is_left_open(pages: dict[str, str]) -> None:
    lines = [f"{name}:{number}" for name, page in pages.items() for number, line in open_places(page)]
    assert not lines, "numbers and pictures that are still to come are written <<...>>"


def open_places(page: str) -> list[tuple[int, str]]:
    prose = re.sub(r"```.*?```", lambda block: "\n" * block.group().count("\n"), page, flags=re.DOTALL)
    return [(number, line) for number, line in enumerate(prose.splitlines(), 1) if "<<" in line]


def test_prose_is_not_wider_than_code(pages: dict[str, str]) -> None:
    wide = []
    for name, page in pages.items():
        prose = re.sub(r"```.*?```", lambda block: "\n" * block.group().count("\n"), page, flags=re.DOTALL)
        for number, line in enumerate(prose.splitlines(), 1):
            if len(line) > WIDTH and not line.startswith(("|", "    ")):  # tables and examples cannot be wrapped
                wide.append(f"{name}:{number} ({len(line)})")
    assert not wide
