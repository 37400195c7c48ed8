from __future__ import annotations

import json
import random
import shutil
from pathlib import Path

import numpy as np
import onnx
import pytest
from safetensors.numpy import load, save

from gaitflow.config.scenario import digest_of
from gaitflow.publishing import verify
from gaitflow.publishing.verify_map import inspect
from gaitflow.runtime import ArtifactError, GaitMap
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.atlas_file import atlas_bytes
from gaitflow.runtime.files import entry_of
from gaitflow.runtime.manifest import encode
from gaitflow.solvers.interior_point import InteriorPoint, Outcome
from gaitflow.solvers.point import Point

FILES = [
    "README.md", "atlas.safetensors", "classifier.onnx", "manifest.json", "problem_check.safetensors",
    "warmstarts.safetensors",
]  # fmt: skip


def forge(artifact: Path, **fields: object) -> None:
    """Change the manifest and make its digests right again, as a careful forger would."""
    path = artifact / "manifest.json"
    data = json.loads(path.read_text(encoding="utf-8")) | fields
    for name in data["files"]:
        entry = entry_of((artifact / name).read_bytes())
        data["files"][name] = {"sha256": entry.sha256, "bytes": entry.bytes}
    path.write_bytes(encode(data))


def test_a_sound_artifact_has_no_findings(pristine: Path) -> None:
    assert verify(pristine) == []


@pytest.mark.parametrize("name", FILES)
def test_any_flipped_bit_is_found(artifact: Path, name: str) -> None:
    path = artifact / name
    content = path.read_bytes()
    rng = random.Random(name)
    for _ in range(80):
        position, bit = rng.randrange(len(content)), rng.randrange(8)
        flipped = bytearray(content)
        flipped[position] ^= 1 << bit
        path.write_bytes(flipped)
        findings = verify(artifact)
        assert [finding.file for finding in findings] == [name], f"bit {bit} of byte {position}"
    path.write_bytes(content)
    assert inspect(artifact) == []


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("damage", ["truncated", "longer", "empty", "missing", "folder", "link"])
def test_damaged_files_are_found(artifact: Path, tmp_path: Path, name: str, damage: str) -> None:
    path = artifact / name
    content = path.read_bytes()
    path.unlink()
    if damage == "truncated":
        path.write_bytes(content[: len(content) // 2])
    elif damage == "longer":
        path.write_bytes(content + b"\0")
    elif damage == "empty":
        path.touch()
    elif damage == "folder":
        path.mkdir()
    elif damage == "link":
        (tmp_path / "elsewhere").write_bytes(content)
        path.symlink_to(tmp_path / "elsewhere")
    assert name in [finding.file for finding in verify(artifact)]


def test_foreign_files_are_found(artifact: Path) -> None:
    (artifact / "notes.txt").touch()
    (artifact / "__pycache__").mkdir()
    assert [finding.file for finding in verify(artifact)] == ["__pycache__", "notes.txt"]


def test_a_folder_named_after_another_version_is_found(artifact: Path) -> None:
    moved = artifact.rename(artifact.with_name("2.0.0"))
    assert "the folder is called 2.0.0, the manifest says 1.0.0" in str(verify(moved)[0])


def test_a_missing_folder_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(ArtifactError, match="no such folder"):
        verify(tmp_path / "none")


@pytest.mark.parametrize(
    ("field", "value", "fault"),
    [
        ("scenario_digest", "0" * 64, "scenario_digest is 000"),
        ("cost_scale", -1.0, "cost_scale = -1.0: must be a number above 0"),
        ("created", "yesterday", "must be UTC such as"),
        ("gaits", [], "gaits = []: must be a list of 1"),
        ("extra", 1, "unknown field 'extra'"),
        ("version", "1.0", "write <major>"),
        ("solver", {"options": {"output_file": "/tmp/x"}}, "may not set this option"),
    ],
)
def test_forged_manifests_are_found(artifact: Path, field: str, value: object, fault: str) -> None:
    forge(artifact, **{field: value})
    findings = verify(artifact)
    assert {finding.file for finding in findings} == {"manifest.json"}
    assert fault in str(findings[0])


def test_a_gait_under_a_wrong_name_is_found(artifact: Path) -> None:
    gaits = json.loads((artifact / "manifest.json").read_text(encoding="utf-8"))["gaits"]
    gaits[0]["name"] = "trot"
    forge(artifact, gaits=gaits)
    assert "('trot', " in str(verify(artifact)[0])
    assert "'walking'" in str(verify(artifact)[0])


def test_a_domain_that_is_not_the_scenarios_is_found(artifact: Path) -> None:
    domain = json.loads((artifact / "manifest.json").read_text(encoding="utf-8"))["domain"]
    domain["axes"]["speed"][-1] = 9.0
    forge(artifact, domain=domain)
    assert "domain is" in str(verify(artifact)[0])


@pytest.mark.parametrize("fault", ["nan", "crossed bounds", "outside", "float32", "shape", "missing"])
def test_forged_tensors_are_found(artifact: Path, fault: str) -> None:
    path = artifact / "warmstarts.safetensors"
    tensors = load(path.read_bytes())
    if fault == "nan":
        tensors["primal"][0, 5] = np.nan
    elif fault == "crossed bounds":
        tensors["lower_bounds"][1, 5] = len(tensors["levels"]) - 1  # infinite, the highest one
        tensors["upper_bounds"][1, 5] = 0
    elif fault == "outside":
        tensors["primal"][1, -1] = 3.0
    elif fault == "float32":
        tensors["primal"] = tensors["primal"].astype(np.float32)
    elif fault == "shape":
        tensors["primal"] = tensors["primal"][:, :-1].copy()
    else:
        del tensors["upper_rows"]
    path.write_bytes(save(tensors))
    forge(artifact)
    assert [finding.file for finding in verify(artifact)] == ["warmstarts.safetensors"]


@pytest.mark.parametrize("content", [b"", b"not onnx", b"\x08\x08" + bytes(100)])
def test_a_classifier_that_is_no_graph_is_found(artifact: Path, content: bytes) -> None:
    (artifact / "classifier.onnx").write_bytes(content)
    forge(artifact)
    assert [finding.file for finding in verify(artifact)] == ["classifier.onnx"]


def test_probabilities_that_do_not_add_up_are_found(artifact: Path) -> None:
    path = artifact / "classifier.onnx"
    model = onnx.load_from_string(path.read_bytes())
    softmax = model.graph.node[-1]
    softmax.op_type = "Relu"
    del softmax.attribute[:]
    path.write_bytes(model.SerializeToString())
    forge(artifact)
    assert "sum 1" in str(verify(artifact)[0])


@pytest.mark.parametrize("name", ["w", "costs", "rows", "tasks"])
def test_values_of_another_problem_are_found(artifact: Path, name: str) -> None:
    path = artifact / "problem_check.safetensors"
    tensors = load(path.read_bytes())
    tensors[name][1, ...] += 1e-3
    path.write_bytes(save(tensors))
    forge(artifact)
    (finding,) = verify(artifact)
    assert finding.file == "problem_check.safetensors"
    assert "makes another problem" in finding.fault


def test_a_scenario_of_another_problem_is_found(artifact: Path) -> None:
    data = json.loads((artifact / "manifest.json").read_text(encoding="utf-8"))
    data["scenario"]["robot"]["mass"] = 15.0
    forge(artifact, scenario=data["scenario"], scenario_digest=digest_of(data["scenario"]))
    assert "problem_check.safetensors" in {finding.file for finding in verify(artifact)}


def test_a_problem_check_that_is_none_is_found(artifact: Path) -> None:
    (artifact / "problem_check.safetensors").write_bytes(b"not tensors")
    forge(artifact)
    assert [finding.file for finding in verify(artifact)] == ["problem_check.safetensors"]


@pytest.mark.parametrize(
    ("name", "value", "fault"),
    [
        ("0.costs", np.nan, "0.costs holds a value that is not finite"),
        ("0.costs", -1.0, "holds a cost that is not positive"),
        ("1.tasks", 1000.0, "has a node or an infeasible place that is no physical task"),
        ("1.tasks", 9.0, "gallop has a node at speed 9 m/s, cycle_duration 9 s, outside the map's domain"),
        ("1.lower", 255, "1.lower has level 255; there are"),
        ("1.pattern", 1, "the pattern 1111/1111 of a sheet is not the gait gallop"),
        ("steps", 0.0, "steps must be positive"),
    ],
)
def test_a_forged_atlas_is_found(artifact: Path, name: str, value: float, fault: str) -> None:
    path = artifact / "atlas.safetensors"
    tensors = load(path.read_bytes())
    tensors[name][...] = value
    path.write_bytes(save(tensors))
    forge(artifact)
    (finding,) = verify(artifact)
    assert finding.file == "atlas.safetensors"
    assert fault in finding.fault


@pytest.mark.parametrize("version", ["1.0.0", "1.1.0"])
def test_published_maps_of_older_formats_are_verified(checkout: Path, tmp_path: Path, version: str) -> None:
    """Their files are checked; what they plan is not tried, as their problem is code."""
    published = checkout / "models" / "half-cheetah-flat-effort" / version
    copy = Path(shutil.copytree(published, tmp_path / version))
    assert verify(copy) == []
    (copy / "classifier.onnx").write_bytes(b"")
    assert [finding.file for finding in verify(copy)] == ["classifier.onnx"]


def lost(method: InteriorPoint, task: np.ndarray, start: Point, unit: float, *_: object, **__: object) -> Outcome:
    return Outcome("lost", 1, method.space.fixed.copy(), start, unit, 1.0)


def test_a_start_that_does_not_plan_is_found(artifact: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # All files are consistent, but the motions are noise, the fast method is lost and the solver gets one iteration.
    monkeypatch.setattr(InteriorPoint, "follow", lost)
    (artifact / "atlas.safetensors").write_bytes(atlas_bytes(Atlas.empty(("speed", "cycle_duration"))))
    path = artifact / "warmstarts.safetensors"
    tensors = load(path.read_bytes())
    bounds = [tensors["levels"][tensors[name]] for name in ("lower_bounds", "upper_bounds")]
    low, high = np.maximum(bounds[0], -1), np.minimum(bounds[1], 1)
    tensors["primal"] = low + np.random.default_rng(0).uniform(size=low.shape) * (high - low)
    path.write_bytes(save(tensors))
    forge(artifact, solver={"options": {"max_iter": 1}})
    assert inspect(artifact) == []
    findings = verify(artifact, tasks=2)
    assert len(findings) == 2
    assert "no feasible plan for speed" in str(findings[0])


def test_a_verified_copy_still_answers(artifact: Path, tmp_path: Path) -> None:
    copy = Path(shutil.copytree(artifact, tmp_path / "mine"))
    assert verify(copy, tasks=1) == []
    assert GaitMap.load(copy).select(0.5, 0.6).gait == "walking"
