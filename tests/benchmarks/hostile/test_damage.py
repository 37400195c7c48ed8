from __future__ import annotations

import copy
import json
import random
import shutil
import struct
import zlib
from pathlib import Path

import numpy as np
import onnx
import pytest
from safetensors.numpy import save

from benchmarks.hostile import configs, datasets, map_bin, urdfs
from benchmarks.hostile.bench import run
from benchmarks.hostile.damage import damaged_bytes
from benchmarks.hostile.fields import damaged_field, fields_of, oddities_of
from benchmarks.hostile.graphs import WAYS
from benchmarks.hostile.remade import remade
from benchmarks.hostile.tensors import header_fields, header_of, with_header
from gaitflow.config.scenario import Scenario
from gaitflow.problem import transcribe
from gaitflow.runtime.problem_check import parse_problem_check


def test_damaged_bytes_are_repeated_by_their_seed() -> None:
    for seed in range(200):
        assert damaged_bytes(b"abc" * 50, random.Random(seed)) == damaged_bytes(b"abc" * 50, random.Random(seed))


def test_every_field_is_damaged_in_every_way_that_changes_it() -> None:
    data = {"a": [1, 2.5, {"b": "c"}], "d": None, "e": {"0.x": [True], "1.x": [False]}}
    before = copy.deepcopy(data)
    paths = list(fields_of(data, alike=lambda name: name.rpartition(".")[2]))
    assert paths == [("a",), ("a", 0), ("d",), ("e",), ("e", "0.x"), ("e", "0.x", 0)]
    for path in paths:
        ways = oddities_of(data, path)
        made = [damaged_field(data, path, way) for way in ways]
        assert data == before and all(each != data or str(each) != str(data) for each in made)
        assert {"missing", "text", "list", "1e308", "deep"} <= set(ways)
    assert damaged_field(data, ("a", 0), "missing")["a"] == data["a"][1:]
    assert "null" not in oddities_of(data, ("d",)) and "longer" in oddities_of(data, ("a",))


def test_a_damaged_header_is_followed_by_the_same_numbers() -> None:
    content = save({"a": np.arange(4.0), "0.b": np.zeros(2), "1.b": np.ones(2)})
    damages = header_fields(content)
    assert {path[0] for path, _ in damages} == {"a", "0.b"}
    for path, oddity in damages:
        bad = with_header(content, path, oddity)
        assert header_of(bad) != header_of(content) and bad.endswith(content[-64:])


@pytest.mark.parametrize("way", WAYS)
def test_graphs_are_damaged_in_each_way(checkout: Path, tmp_path: Path, way: str) -> None:
    content = (checkout / "models/half-cheetah-exact-effort/1.1.0/classifier.onnx").read_bytes()
    for seed in range(20):
        model = onnx.load_model_from_string(content)
        try:
            WAYS[way](model, tmp_path, random.Random(seed))
            changed = model.SerializeToString() != content
        except (ValueError, TypeError):  # protobuf refuses a number that does not fit its field
            continue
        if changed:
            return
    pytest.fail(f"{way} changes nothing")


def test_a_map_of_other_numbers_is_proved_to_be_that_problem(checkout: Path) -> None:
    manifest = json.loads((checkout / "models/half-cheetah-exact-effort/1.1.0/manifest.json").read_bytes())
    before = copy.deepcopy(manifest["scenario"])
    changed, check = remade(manifest, random.Random(1))
    scenario = changed["scenario"]
    assert scenario != before
    problem = transcribe(Scenario.from_data(scenario, "s"))
    assert changed["cost_scale"] == problem.cost_scale
    assert parse_problem_check(check, problem.layout, problem.ng, "c").differs(problem.nlp) is None


def test_a_damaged_map_bin_has_its_checksum() -> None:
    content = bytes(16) + struct.pack("<Q", 4096) + bytes(32) + struct.pack("<Q", 3) * 505
    for seed in range(50):
        _, bad = map_bin.damaged(content, random.Random(seed))
        assert struct.unpack_from("<I", bad, 12)[0] == zlib.crc32(bad[16:])
        assert struct.unpack_from("<Q", bad, 16)[0] == len(bad)


def test_the_undamaged_files_are_answered(checkout: Path, tmp_path: Path) -> None:
    configs.prepare(checkout, tmp_path)
    assert len(configs.ask(tmp_path)) == 4
    folder = Path(
        shutil.copytree(checkout / "tests/data/datasets/half-cheetah-slope20-vibration/1.0.0", tmp_path / "d")
    )
    version, rows, motions, *_ = datasets.ask(folder)
    assert (version, rows, motions) == ("1.0.0", 144, 12)


def test_the_undamaged_description_is_imported(tmp_path: Path) -> None:
    urdfs.prepare(tmp_path)
    robot = urdfs.ask(tmp_path)
    assert robot["mass"] == pytest.approx(20 + 4 * (3 * 0.1 + 0.5))
    assert [leg["name"] for leg in robot["legs"]] == ["LF", "RF", "LH", "RH"]
    assert robot["frames"]["feet"][0]["contact_point"][2] != 0


@pytest.mark.slow
def test_a_few_of_each_kind_are_no_fault(checkout: Path) -> None:
    done = run(checkout, seed=3, tasks=8)
    assert list(done["summary"]) == ["maps", "configs", "datasets", "urdfs", "map_bin", "seed"]
    for kind in ("maps", "configs", "datasets", "urdfs", "map_bin"):
        assert done["summary"][kind]["cases"] == 8
        assert done["summary"][kind]["fault"] == 0, [row for row in done["rows"] if row["faults"]]
    assert json.dumps(done)
