"""The example of docs/clients.md runs as it is written."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path


def test_the_example_of_both_solvers_runs(checkout: Path) -> None:
    page = (checkout / "docs" / "clients.md").read_text(encoding="utf-8")
    (code,) = (block for block in re.findall(r"```python\n(.*?)```", page, flags=re.DOTALL) if "shoot(" in block)
    done = subprocess.run([sys.executable, "-c", code], cwd=checkout, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    answers = [line.split() for line in done.stdout.splitlines()]
    assert [ready for ready, *_ in answers] == ["True"] * 6
