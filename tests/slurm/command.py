"""Run gaitflow as its users do."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def gaitflow(root: Path, *arguments: object) -> str:
    """What a command prints, in the workspace `root`. Fails with what it said when it fails."""
    command = [sys.executable, "-m", "gaitflow.cli", "--root", root, *arguments]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout
