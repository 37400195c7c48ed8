"""docs/cluster.md describes what exists: its commands, options, files, profile fields and messages."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import click
import pytest

from gaitflow.cli import main
from gaitflow.cli.bench import BENCHES
from gaitflow.config.cluster import Driver, Profile, load_profile
from gaitflow.config.scenario import Strategy

BLOCK = re.compile(r"^```bash\n(.*?)^```$", re.DOTALL | re.MULTILINE)
INLINE = re.compile(r"`(gaitflow [a-z][^`]*)`")


@pytest.fixture(scope="module")
def page(checkout: Path) -> str:
    return (checkout / "docs" / "cluster.md").read_text(encoding="utf-8")


def table(page: str, heading: str) -> list[list[str]]:
    """Rows of the table below a heading, without its two first lines."""
    section = page.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    rows = [line.strip("|").split(" | ") for line in section.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in row] for row in rows[2:]]


def commands(page: str) -> list[list[str]]:
    lines = [line for block in BLOCK.findall(page) for line in block.splitlines()] + INLINE.findall(page)
    return [shlex.split(line) for line in lines]


def test_every_command_names_what_there_is(page: str, checkout: Path) -> None:
    found = commands(page)
    assert {words[1] for words in found} == {
        "doctor", "submit", "status", "cancel", "run", "solve", "compact", "bench", "init", "estimate"
    }  # fmt: skip
    for words in found:
        assert words[0] == "gaitflow"
        command = main.commands[words[1]]
        options = {name: each for each in command.params if isinstance(each, click.Option) for name in each.opts}
        arguments = [each for each in command.params if isinstance(each, click.Argument)]
        rest = iter(words[2:])
        plain = []
        for word in rest:
            if not word.startswith("-"):
                plain.append(word)
                continue
            assert word in options, f"{' '.join(words)}: no option {word}"
            value = None if options[word].is_flag else next(rest)
            if word == "--profile" and value != "FILE":
                assert load_profile(checkout / str(value)).jobs >= 1
        assert len(plain) <= len(arguments)
        for argument, word in zip(arguments, plain, strict=False):
            if argument.name == "scenario":
                assert (checkout / "configs" / "scenarios" / f"{word}.yaml").is_file()
            if argument.name == "name":
                assert word in BENCHES


def test_every_field_of_a_profile_is_described_with_its_default(page: str) -> None:
    rows = table(page, "A profile, field by field")
    described = {name: row[-1] for row in rows for name in re.findall(r"`(\w+)`", row[0])}
    assert set(described) == set(Profile.model_fields)
    assert {"walltime", "memory", "partition", "directives"} == set(Driver.model_fields)
    for name in ("memory", "cores", "margin_s"):
        assert str(Profile.model_fields[name].default).removesuffix(".0") in described[name]
    assert described["tls"] == "true" and Profile.model_fields["tls"].default is True
    assert Driver().walltime.startswith("2-") and Driver().memory in described["driver"]


def test_every_message_is_one_that_the_code_gives(page: str, checkout: Path) -> None:
    code = "".join(path.read_text(encoding="utf-8") for path in (checkout / "gaitflow").rglob("*.py"))
    code = re.sub(r'"\s*\n\s*f?"', "", code)
    rows = table(page, "What happens when something dies")
    quoted = [message for row in rows for message in re.findall(r'^"(.*)"$', row[0])]
    assert len(quoted) >= 7
    for message in quoted:
        for piece in re.split(r"\.\.\.|\bn\b|\(.*\)", message):
            assert piece.strip(" ,") in code, message
    assert len(rows) >= 11 and all(len(row) == 4 and all(row) for row in rows)


def test_links_and_names_of_the_page_exist(page: str, checkout: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", page):
        assert (checkout / "docs" / target).exists(), target
    assert "tasks_per_unit" in Strategy.model_fields
