from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from gaitflow.cli import main


def run(*arguments: str) -> Result:
    return CliRunner().invoke(main, ["drive", *arguments], catch_exceptions=False)


@pytest.fixture
def anymal(checkout: Path) -> str:
    return str(checkout / "models" / "anymal-energy")


@pytest.mark.slow
def test_a_drive_is_numbers_and_a_picture(anymal: str, tmp_path: Path) -> None:
    chart = tmp_path / "drive.png"
    result = run(anymal, "--top", "0.4", "--seconds", "8", "--json", "--video", str(chart))
    data = json.loads(result.output)
    assert result.exit_code == 0
    assert data["fell"] is None and data["changes"] and data["tick_ms"]["p99"] > 0
    assert chart.read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_a_drive_is_a_page(anymal: str, tmp_path: Path) -> None:
    page = tmp_path / "drive.html"
    result = run(anymal, "--top", "0.3", "--seconds", "5", "--video", str(page))
    assert result.exit_code == 0 and "drove:               yes" in result.output
    text = page.read_text()
    assert "Content-Security-Policy" in text and "http://" not in text and "https://" not in text


def test_bad_input_is_one_line_and_exit_code_2(anymal: str, checkout: Path, tmp_path: Path) -> None:
    for arguments in (
        (anymal, "--video", str(tmp_path / "drive.gif")),
        (str(checkout / "models" / "half-cheetah-exact-vibration"),),
        (str(tmp_path),),
        (anymal, "--top", "0"),
    ):
        result = run(*arguments)
        assert result.exit_code == 2, result.output
