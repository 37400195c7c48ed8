"""The loops of examples/ run as they are, on published maps; the C++ one needs cmake, cc and g++."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from pathlib import Path

import pytest
from cpp_program import built

from gaitflow.export import export_c

MAP = "half-cheetah-exact-vibration"
MOST_LINES = 40


def ran(*command: str | Path) -> str:
    done = subprocess.run([str(each) for each in command], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_loop_in_python_changes_its_speed(checkout: Path) -> None:
    loop = checkout / "examples" / "loop.py"
    assert len(loop.read_text(encoding="utf-8").splitlines()) <= MOST_LINES
    *seconds, last = ran(sys.executable, loop, checkout / "models" / MAP, "5").splitlines()
    told = [re.fullmatch(r" *(\d)\.00 s +(\S+) m/s +(.+?) +[-|] [-|] +x = (\S+) m", line) for line in seconds]
    assert all(told), seconds
    speeds = [float(line[2]) for line in told if line]
    places = [float(line[4]) for line in told if line]
    assert speeds[0] == 0.4 and len(set(speeds)) >= 3
    assert places[0] == 0 and places == sorted(places)
    assert len({line[3] for line in told if line}) >= 2, "the gait changes, too"
    assert float(last.split(":")[1].split()[0]) == pytest.approx(speeds[-1], abs=0.4)


@pytest.mark.timeout(400)  # it compiles a map, on machines that do other things, too
@pytest.mark.slow
def test_the_loop_in_cpp_keeps_its_rate(checkout: Path, tmp_path: Path) -> None:
    exported = export_c(checkout / "models" / MAP, tmp_path / "c")
    program = built(exported.folder, tmp_path / "build", "loop")
    began = time.perf_counter()
    *lines, last = ran(program, exported.folder / "map.bin", "2").splitlines()
    assert time.perf_counter() - began >= 1.9
    assert len(lines) == 20
    told = [re.fullmatch(r" *(\S+) s +(\S+) m/s +(.+?) +(\S+) ms", line) for line in lines]
    assert sum(line is not None and "outside" not in line[3] for line in told) >= 10
    speeds = [float(line[2]) for line in told if line]
    assert speeds == sorted(speeds) and speeds[-1] > 2 * speeds[0]
    assert re.fullmatch(r"100 turns, \d+ late, the longest plan took \S+ ms", last)
