"""Which modules of gaitflow a fresh process imports."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

_TELL = """
import sys
for name, module in sys.modules.items():
    if name.startswith("gaitflow"):
        print(name, module.__file__)
"""


def loaded_by(code: str) -> dict[str, Path]:
    """Modules of gaitflow by name, each with its file, that are loaded once `code` has run."""
    done = subprocess.run([sys.executable, "-c", code + _TELL], capture_output=True, text=True, check=True)
    pairs = (line.split(" ", 1) for line in done.stdout.splitlines())
    return {name: Path(file) for name, file in pairs}
