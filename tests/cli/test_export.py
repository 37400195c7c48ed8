"""`gaitflow export` on a published map."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from gaitflow.cli import main
from gaitflow.export.export import CONTENT


def ask(*arguments: object) -> Result:
    return CliRunner().invoke(main, ["export", *map(str, arguments)])


@pytest.fixture(scope="module")
def model(checkout: Path) -> Path:
    return checkout / "models/half-cheetah-flat-effort/1.0.0"


def test_it_writes_a_folder_and_lists_it(model: Path, tmp_path: Path) -> None:
    answer = ask(model, "--c", tmp_path / "out", "--trust-code", "--json")
    assert answer.exit_code == 0, answer.output
    data = json.loads(answer.stdout)
    assert data["folder"] == str(tmp_path / "out") and data["model"] == str(model)
    assert sorted(data["files"]) == sorted(CONTENT) == sorted(path.name for path in (tmp_path / "out").iterdir())
    lines = ask(model, "--c", tmp_path / "out", "--trust-code").stdout.splitlines()
    assert lines[0] == f"{model} -> {tmp_path / 'out'}"
    assert [line.split()[1] for line in lines[1:]] == list(data["files"])


def test_what_cannot_be_exported_is_one_clear_line(model: Path, tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    for arguments, says in (
        ((model, "--c", tmp_path), "holds 'notes.txt', which no export writes"),
        ((tmp_path / "none", "--c", tmp_path / "out"), "no map here"),
        ((model,), "--c"),
        ((model, "--c", tmp_path / "out"), "--trust-code"),
    ):
        answer = ask(*arguments)
        assert answer.exit_code == 2 and says in answer.stderr
        assert "Traceback" not in answer.output
    refused = ask(model, "--c", tmp_path / "notes.txt" / "out", "--trust-code")
    assert refused.exit_code == 1 and "notes.txt" in refused.stderr


def test_help_has_an_example() -> None:
    assert "Example: gaitflow export " in ask("--help").stdout
