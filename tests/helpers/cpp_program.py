"""The programs of examples/cpp, built with an export; needs cmake, cc and g++ (apt-get install cmake g++)."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterable, Sequence
from pathlib import Path

import gaitflow.export

HEADERS = Path(gaitflow.export.__file__).parent / "cpp"
EXAMPLES = Path(__file__).parents[2] / "examples" / "cpp"
SANITIZED = "-O1 -g -Wall -Wextra -Werror -fno-sanitize-recover=all -fsanitize="


def built(export: Path, build: Path, program: str, flags: str = "", source: Path = EXAMPLES) -> Path:
    """One program of a CMake project, with a map from a folder; `flags` are for its C++ part."""
    for tool in ("cmake", "cc", "g++"):
        assert shutil.which(tool), f"{tool} is missing, so the export cannot be tested: apt-get install cmake g++"
    names = [f"-Dgaitflow_map_DIR={export}", "-DCMAKE_C_COMPILER=cc", "-DCMAKE_CXX_COMPILER=g++"]
    if flags:
        names += [f"-DCMAKE_CXX_FLAGS={flags}", "-DCMAKE_C_FLAGS=-O1", "-DCMAKE_BUILD_TYPE=None"]
    for command in (["-S", str(source), "-B", str(build), *names], ["--build", str(build), "--target", program]):
        done = subprocess.run(["cmake", *command], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
    return build / program


def compiled(source: Path, folder: Path, *flags: str) -> Path:
    """One file that includes the exported headers, compiled on its own into a folder."""
    assert shutil.which("g++"), "g++ is missing, so the export cannot be tested: apt-get install g++"
    command = ["g++", "-std=c++17", "-Wall", "-Wextra", "-Werror", *flags, f"-I{HEADERS}", str(source)]
    done = subprocess.run([*command, "-o", str(folder / "program")], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder / "program"


def run(program: Path, map_file: Path, text: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([str(program), str(map_file)], input=text, capture_output=True, text=True, check=False)


def lines(tasks: Iterable[Sequence[float]]) -> str:
    """Tasks, values in the order of the map's axes, as the programs read them."""
    return "".join(" ".join(repr(float(value)) for value in task) + "\n" for task in tasks)
