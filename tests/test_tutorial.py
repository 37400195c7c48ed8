"""docs/your-own-robot.md says that its commands work, in that order, in an empty folder: they do."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from gaitflow.config.robot import load_robot

ALL = re.compile(r"^```bash\n(.*?)^```$", re.DOTALL | re.MULTILINE)


@pytest.mark.slow
@pytest.mark.timeout(600)  # under a minute on two idle cores; they need not be idle
def test_the_tutorial_runs(checkout: Path, tmp_path: Path) -> None:
    blocks = ALL.findall((checkout / "docs" / "your-own-robot.md").read_text(encoding="utf-8"))
    assert len(blocks) >= 5
    environment = os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}", "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", "\n".join(blocks)],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert load_robot(tmp_path / "configs/robots/go2.yaml").leg_names == ("LF", "RF", "LH", "RH")
    assert "cannot reach its corner" in done.stderr and "refused, as it should be" in done.stdout
    assert not (tmp_path / "configs/robots/too_long.yaml").exists()
    assert len(re.findall(r"^ *\d\.\d+ m/s .* cost ", done.stdout, re.MULTILINE)) == 4, "four labels"
    assert re.search(r"^feasible: +yes", done.stdout, re.MULTILINE)
    assert (tmp_path / "motion.html").stat().st_size > 1000
