from __future__ import annotations

import copy
import json
import random
import shutil
import struct
import zlib
from pathlib import Path

import pytest

from benchmarks.hostile import configs, datasets, map_bin
from benchmarks.hostile.bench import run
from benchmarks.hostile.damage import damaged_bytes, damaged_data


def test_damage_is_repeated_by_its_seed_and_leaves_the_original() -> None:
    data = {"a": [1, 2.5, {"b": "c"}], "d": None}
    before = copy.deepcopy(data)
    for seed in range(200):
        first, second = (damaged_data(data, random.Random(seed)) for _ in range(2))
        assert str(first) == str(second) and data == before
        assert damaged_bytes(b"abc" * 50, random.Random(seed)) == damaged_bytes(b"abc" * 50, random.Random(seed))


def test_a_damaged_map_bin_has_its_checksum() -> None:
    content = bytes(16) + struct.pack("<Q", 4096) + bytes(32) + struct.pack("<Q", 3) * 505
    for seed in range(50):
        _, bad = map_bin.damaged(content, random.Random(seed))
        assert struct.unpack_from("<I", bad, 12)[0] == zlib.crc32(bad[16:])
        assert struct.unpack_from("<Q", bad, 16)[0] == len(bad)


def test_the_undamaged_files_are_answered(checkout: Path, tmp_path: Path) -> None:
    configs.prepare(checkout, tmp_path)
    *_, name, mass = configs.ask(tmp_path, 0)
    assert (name, mass) == ("a", 4.0)
    folder = Path(
        shutil.copytree(checkout / "tests/data/datasets/half-cheetah-slope20-vibration/1.0.0", tmp_path / "d")
    )
    version, rows, motions, *_ = datasets.ask(folder, 0)
    assert (version, rows, motions) == ("1.0.0", 144, 12)


@pytest.mark.slow
def test_a_few_of_each_kind_are_no_fault(checkout: Path) -> None:
    done = run(checkout, seed=3, tasks=8)
    assert list(done["summary"]) == ["maps", "configs", "datasets", "map_bin", "seed"]
    for kind in ("maps", "configs", "datasets", "map_bin"):
        assert done["summary"][kind]["cases"] == 8
        assert done["summary"][kind]["fault"] == 0, [row for row in done["rows"] if row["faults"]]
    assert json.dumps(done)
