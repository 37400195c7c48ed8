"""Damaged files of exported maps, their checksums made right again, read in C++ under its sanitizers."""

from __future__ import annotations

import os
import random
import struct
import subprocess
import zlib
from hashlib import sha256
from pathlib import Path

from benchmarks.hostile.damage import damaged_bytes
from benchmarks.hostile.sandbox import CPU_S, LONGEST_LINE, WALL_S, Outcome
from gaitflow.export.classifier_data import read_classifier
from gaitflow.export.map_file import map_bytes
from gaitflow.runtime.artifact import load_artifact
from gaitflow.runtime.files import CLASSIFIER, MANIFEST

START = 56  # bytes before the first item
ODD_COUNTS = (0, 1, 2, 7, 4096, 10**6, 2**31, 2**32, 2**61, 2**63, 2**64 - 1)
ODD_NUMBERS = (1e308, -1e308, 1e30, float("nan"), float("inf"), -float("inf"), -1.0, 0.0, 5e-324, 1e-12)
SMALL = 10**8  # an unsigned number below this is a count and no float64
FLAGS = ("-std=c++17", "-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
SANITIZERS = {
    "ASAN_OPTIONS": "exitcode=99:max_allocation_size_mb=4096:hard_rss_limit_mb=3000:detect_leaks=1",
    "UBSAN_OPTIONS": "exitcode=99",
}


def built(checkout: Path, program: Path) -> Path:
    """The program that reads and asks, with sanitizers. Raises CalledProcessError; needs g++."""
    folders = (checkout / "gaitflow/export/cpp", checkout / "examples/cpp")
    source = checkout / "benchmarks/hostile/ask_map.cpp"
    includes = [f"-I{folder}" for folder in folders]
    subprocess.run(["g++", *FLAGS, *includes, str(source), "-o", str(program)], check=True, capture_output=True)
    return program


def exported(model: Path) -> bytes:
    """map.bin of a published map."""
    artifact = load_artifact(model)
    kind = artifact.manifest.classifier_kind
    data = read_classifier((model / CLASSIFIER).read_bytes(), kind, str(model / CLASSIFIER))
    return map_bytes(artifact, sha256((model / MANIFEST).read_bytes()).digest(), data)


def damaged(content: bytes, chance: random.Random) -> tuple[str, bytes]:
    """How a map.bin was damaged, and what came of it, with the size and the checksum of what it then holds."""
    words = len(content) // 8
    how, data = chance.choice(["count"] * 3 + ["number"] * 2 + ["bytes", "beginning"]), bytearray(content)
    if how == "beginning":
        data[chance.choice([*range(12), *range(24, START)])] ^= 1 << chance.randrange(8)
    elif how == "bytes":
        how, data = damaged_bytes(content[START:], chance)[0], bytearray(content[:START])
        data += damaged_bytes(content[START:], chance)[1]
    elif how == "number":
        for _ in range(chance.choice([1, 1, 50])):
            struct.pack_into("<d", data, 8 * chance.randrange(START // 8, words), chance.choice(ODD_NUMBERS))
    else:
        counts = [at for at in range(START, 8 * words, 8) if 0 < struct.unpack_from("<Q", content, at)[0] < SMALL]
        struct.pack_into("<Q", data, chance.choice(counts), chance.choice(ODD_COUNTS))
    struct.pack_into("<Q", data, 16, len(data))
    struct.pack_into("<I", data, 12, zlib.crc32(data[16:]))
    return how, bytes(data)


def ask(program: Path, file: Path, tasks: str) -> Outcome:
    """What the program says of a map.bin and tasks, a line each."""
    command = ["prlimit", f"--cpu={CPU_S}", str(program), str(file)]
    try:
        done = subprocess.run(
            command,
            input=tasks,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=WALL_S,
            env=os.environ | SANITIZERS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return Outcome("hang", f"no answer after {WALL_S} s")
    said = done.stderr.strip()
    match done.returncode:
        case 0:
            return Outcome("same answer", done.stdout)
        case 1 if said.count("\n") == 0 and 0 < len(said) < LONGEST_LINE:
            return Outcome("refused", said)
        case 3:
            return Outcome("unsound", "a number is not finite")
        case -24 | 152:
            return Outcome("hang", f"no answer after {CPU_S} s of CPU")
    return Outcome(
        "crash", next((line for line in said.splitlines() if "ERROR" in line or "error" in line), said)[:300]
    )
