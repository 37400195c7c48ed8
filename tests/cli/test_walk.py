from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from gaitflow.cli import main


@pytest.fixture
def run(checkout: Path):
    def invoke(*arguments: str) -> Result:
        return CliRunner().invoke(main, ["walk", *arguments], catch_exceptions=False)

    return invoke


@pytest.fixture
def anymal(checkout: Path) -> str:
    return str(checkout / "models" / "anymal-exact-vibration")


def test_walk_prints_its_numbers_and_writes_a_page(run, anymal: str, tmp_path: Path) -> None:
    page = tmp_path / "walk.html"
    result = run(anymal, "--speed", "0.6", "--cycle", "0.6", "--cycles", "2", "--video", str(page))
    assert result.exit_code == 0, result.output
    assert "cost of transport:" in result.output and "walked:              yes" in result.output
    text = page.read_text()
    assert "Content-Security-Policy" in text and "http://" not in text and "https://" not in text


def test_json_is_one_document_and_the_strip_a_png(run, anymal: str, tmp_path: Path) -> None:
    strip = tmp_path / "walk.png"
    result = run(anymal, "--speed", "0.6", "--cycle", "0.6", "--cycles", "1", "--json", "--video", str(strip))
    data = json.loads(result.output)
    assert result.exit_code == 0
    assert data["walk"]["walked"] is True and data["plan"]["feasible"] is True
    assert strip.read_bytes().startswith(b"\x89PNG")


def test_robot_that_falls_is_exit_code_1(run, anymal: str) -> None:
    result = run(anymal, "--speed", "1.6", "--cycle", "1.0")
    assert result.exit_code == 1
    assert "fell at" in result.output


def test_bad_input_is_one_line_and_exit_code_2(run, anymal: str, checkout: Path, tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.urdf"
    wrong.write_text("<robot name='box'><link name='base'/></robot>")
    for arguments in (
        (anymal, "--speed", "0.6", "--cycle", "0.6", "--video", str(tmp_path / "walk.gif")),
        (anymal, "--speed", "0.6", "--cycle", "0.6", "--urdf", str(wrong)),
        (str(checkout / "models" / "half-cheetah-exact-vibration"), "--speed", "0.6", "--cycle", "0.6"),
        (str(tmp_path), "--speed", "0.6"),
    ):
        result = run(*arguments)
        assert result.exit_code == 2, result.output
        assert len(result.output.strip().splitlines()) == 1


def test_missing_simulator_is_one_line_that_says_what_to_install(anymal: str) -> None:
    code = "import sys; sys.modules['mujoco'] = None; from gaitflow.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code, "walk", anymal, "--speed", "0.6"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert 'pip install "gaitflow[clients]"' in done.stderr and len(done.stderr.strip().splitlines()) == 1
