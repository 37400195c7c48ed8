from __future__ import annotations

import json
from pathlib import Path

import pytest

from gaitflow.runtime import ArtifactError, GaitMap
from gaitflow.runtime.files import LIMITS
from gaitflow.runtime.manifest import encode, parse_manifest, read_manifest


@pytest.fixture
def data(pristine: Path) -> dict:
    return json.loads((pristine / "manifest.json").read_text(encoding="utf-8"))


def test_what_was_encoded_is_parsed(pristine: Path, data: dict) -> None:
    content = (pristine / "manifest.json").read_bytes()
    assert encode(data) == content
    assert parse_manifest(content, "m") == read_manifest(pristine)


def test_no_flipped_bit_passes(pristine: Path) -> None:
    content = (pristine / "manifest.json").read_bytes()
    for bit in range(0, 8 * len(content), 23):
        flipped = bytearray(content)
        flipped[bit // 8] ^= 1 << bit % 8
        with pytest.raises(ArtifactError):
            parse_manifest(bytes(flipped), "m")


def test_a_newer_format_is_refused_by_name(artifact: Path, data: dict) -> None:
    path = artifact / "manifest.json"
    # Of a newer format nothing is known but its number: neither its fields nor how it is digested.
    path.write_text(json.dumps({"format": 3, "all": "else", "may": "differ"}), encoding="utf-8")
    with pytest.raises(ArtifactError, match=r"has format 3, this gaitflow reads format 1 to 2: update gaitflow"):
        GaitMap.load(artifact)


@pytest.mark.parametrize("number", [0, -1, 1.0, 2.0, True, "1", None])
def test_no_other_format_is_guessed(data: dict, number: object) -> None:
    with pytest.raises(ArtifactError, match="this gaitflow reads format 1 to 2"):
        parse_manifest(encode(data | {"format": number}), "m")


def test_the_older_format_lists_no_atlas_and_the_newer_one_must(data: dict) -> None:
    with pytest.raises(ArtifactError, match=r"m\.files: unknown field 'atlas\.safetensors'"):
        parse_manifest(encode(data | {"format": 1}), "m")
    del data["files"]["atlas.safetensors"]
    assert set(parse_manifest(encode(data | {"format": 1}), "m").files) == set(data["files"])
    with pytest.raises(ArtifactError, match=r"m\.files: missing field 'atlas\.safetensors'"):
        parse_manifest(encode(data), "m")


@pytest.mark.parametrize(
    "content",
    [b"", b"{", b"[]", b"null", b"\xff\xfe", b"[" * 200_000, b'{"format": 1e999}', b"1" * 5000, b'{"format": NaN}'],
)
def test_what_is_no_manifest_is_refused(content: bytes) -> None:
    with pytest.raises(ArtifactError, match=r"^m: "):
        parse_manifest(content, "m")


def test_an_edited_manifest_is_refused(data: dict) -> None:
    edited = (json.dumps(data | {"cost_scale": 2.0}, sort_keys=True, indent=1) + "\n").encode()
    with pytest.raises(ArtifactError, match="does not have the SHA-256 that it states"):
        parse_manifest(edited, "m")


def test_a_field_given_twice_is_refused(pristine: Path) -> None:
    content = (pristine / "manifest.json").read_bytes()
    with pytest.raises(ArtifactError, match="SHA-256"):
        parse_manifest(content.replace(b"{", b'{\n "format": 2,', 1), "m")


@pytest.mark.parametrize("name", ["../../etc/passwd", "/etc/passwd", "a/b.onnx", "..", "classifier.onnx/", "C:\\x", ""])
def test_file_names_that_lead_elsewhere_are_refused(data: dict, name: str) -> None:
    data["files"][name] = data["files"].pop("classifier.onnx")
    with pytest.raises(ArtifactError, match=r"m\.files: (missing|unknown) field"):
        parse_manifest(encode(data), "m")


@pytest.mark.parametrize(
    ("path", "value", "fault"),
    [
        (("version",), "1.0", "write <major>"),
        (("version",), 1, "must be text"),
        (("created",), "2026-13-01T00:00:00Z", "must be UTC"),
        (("scenario",), {"name": "x"}, "a scenario with name, robot"),
        (("scenario_digest",), "A" * 64, "64 lower-case"),
        (("cost_scale",), 0, "above 0"),
        (("cost_scale",), True, "above 0"),
        (("cost_scale",), 10**400, "above 0"),
        (("domain", "speed"), [0.1, 0.1, 0.9, 1.3, 1.7, 2.1], "each above the one before"),
        (("domain", "speed"), ["0.1"], "each above the one before"),
        (("domain", "feasible"), [[True]], "6 rows"),
        (("domain", "feasible", 0, 0), 1, "booleans"),
        (("gaits", 1, "name"), "walking", "different names"),
        (("gaits", 1, "pattern"), "0110", "2 legs and 4 phases"),
        (("gaits", 1, "pattern"), "011/110", "2 legs and 4 phases"),
        (("gaits", 1, "key"), "01x/110", "row of digits"),
        (("layout", "phases"), 10**9, "an integer from 1 to 64"),
        (("layout", "knots_per_phase"), 5, "layout.variables"),
        (("layout", "rows"), 10**12, "an integer from 1 to"),
        (("layout", "legs"), ["F", 2], "names of legs"),
        (("layout", "duration_slice"), [0, 4], "the last 4 variables"),
        (("classifier",), {}, "missing field 'kind'"),
        (("metrics",), [], "must be an object"),
        (("files", "README.md", "bytes"), -1, "an integer from 0"),
        (("files", "warmstarts.safetensors", "bytes"), LIMITS["warmstarts.safetensors"] + 1, "an integer from 0"),
        (("files", "README.md", "sha256"), "0" * 63, "64 lower-case"),
        (("solver", "options"), {"max_iter": -1}, "an integer from 0"),
    ],
)
def test_a_wrong_field_is_named_with_what_is_allowed(data: dict, path: tuple, value: object, fault: str) -> None:
    holder = data
    for step in path[:-1]:
        holder = holder[step]
    holder[path[-1]] = value
    with pytest.raises(ArtifactError) as caught:
        parse_manifest(encode(data), "m")
    assert fault in str(caught.value)
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize("name", ["format", "version", "gaits", "layout", "files", "solver", "manifest_sha256"])
def test_a_missing_field_is_refused(data: dict, name: str) -> None:
    del data[name]
    content = json.dumps(data, sort_keys=True, indent=1).encode() if name == "manifest_sha256" else encode(data)
    with pytest.raises(ArtifactError):
        parse_manifest(content, "m")
