"""The example that plans random tasks runs as it is, on a published map."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

TASKS = 20


def test_random_tasks_are_planned_and_counted_by_path(checkout: Path) -> None:
    command = [sys.executable, checkout / "examples" / "random_tasks.py", checkout / "models/half-cheetah-exact-slopes"]
    done = subprocess.run([*command, str(TASKS)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    head, *counted = done.stdout.splitlines()
    assert head.startswith("half-cheetah-exact-slopes 1.")
    counts = {line[1]: int(line[2]) for each in counted if (line := re.fullmatch(r"(.+?) +(\d+) of 20, .*%", each))}
    feasible = counts.pop("feasible plans")
    assert feasible == TASKS
    assert set(counts) == {"first gait, Newton", "another gait", "by IPOPT"} and sum(counts.values()) == feasible
    assert counts["first gait, Newton"] >= TASKS / 2
    numbers = {line[1]: float(line[2]) for each in counted if (line := re.fullmatch(r"(.+?) {2,}([\d.]+)( ms)?", each))}
    assert numbers["gaits tried, mean"] >= 1 and numbers["time, median"] > 0
