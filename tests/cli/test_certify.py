"""A certificate that cannot be made is refused in one line, before anything is searched."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from gaitflow.cli.main import main
from gaitflow.runtime.files import MANIFEST
from gaitflow.runtime.manifest import encode

MAP = Path(__file__).parents[2] / "models" / "half-cheetah-exact-vibration"


def asked(folder: Path, root: Path) -> Result:
    return CliRunner().invoke(main, ["--root", str(root), "certify", str(folder), "--tasks", "1"])


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    newest = sorted(folder for folder in MAP.iterdir() if folder.is_dir())[-1]
    return Path(shutil.copytree(newest, tmp_path / "map"))


def test_a_map_whose_solver_is_gone_is_refused(copied: Path, tmp_path: Path) -> None:
    manifest = json.loads((copied / MANIFEST).read_text())
    del manifest["manifest_sha256"]
    manifest["scenario"]["transcription"]["integrator"] = "leapfrog"
    (copied / MANIFEST).write_bytes(encode(manifest))
    done = asked(copied, tmp_path)
    assert done.exit_code == 2 and len(done.output.strip().splitlines()) == 1, done.output
    assert "integrator = 'leapfrog'" in done.output
    assert not (tmp_path / "runs").exists(), "nothing was searched"


def test_a_map_whose_atlas_is_gone_is_refused(copied: Path, tmp_path: Path) -> None:
    (copied / "atlas.safetensors").unlink()
    done = asked(copied, tmp_path)
    assert done.exit_code == 2 and "atlas.safetensors" in done.output.splitlines()[-1]
    assert not (tmp_path / "runs").exists()
