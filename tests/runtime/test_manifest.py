from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from gaitflow.runtime import ArtifactError, Frames, GaitMap
from gaitflow.runtime.files import LIMITS
from gaitflow.runtime.manifest import encode
from gaitflow.runtime.manifest_file import parse_manifest, read_manifest


@pytest.fixture
def data(pristine: Path) -> dict:
    return json.loads((pristine / "manifest.json").read_text(encoding="utf-8"))


def test_what_was_encoded_is_parsed(pristine: Path, data: dict) -> None:
    content = (pristine / "manifest.json").read_bytes()
    assert encode(data) == content
    parsed, read = parse_manifest(content, "m"), read_manifest(pristine)
    assert parsed.domain.axes == read.domain.axes and (parsed.domain.feasible == read.domain.feasible).all()
    assert replace(parsed, domain=read.domain) == read
    assert (parsed.format, parsed.gaitflow_version) == (3, "0.0.9")
    assert parsed.space.ranged == tuple(parsed.domain.axes) == ("speed", "cycle_duration")
    assert parsed.dataset == {"name": "quickstart", "version": "1.0.0"}
    assert [(gait.name, gait.key, gait.pattern) for gait in parsed.gaits] == [
        (each["name"], each["key"], each["pattern"]) for each in data["gaits"]
    ]


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
    path.write_text(json.dumps({"format": 4, "all": "else", "may": "differ"}), encoding="utf-8")
    with pytest.raises(ArtifactError, match=r"has format 4, this gaitflow reads format 1 to 3: update gaitflow"):
        GaitMap.load(artifact)


@pytest.mark.parametrize("number", [0, -1, 1.0, 3.0, True, "1", None])
def test_no_other_format_is_guessed(data: dict, number: object) -> None:
    with pytest.raises(ArtifactError, match="this gaitflow reads format 1 to 3"):
        parse_manifest(encode(data | {"format": number}), "m")


def test_every_file_of_the_format_is_listed(data: dict) -> None:
    del data["files"]["problem_check.safetensors"]
    with pytest.raises(ArtifactError, match=r"m\.files: missing field 'problem_check\.safetensors'"):
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
        parse_manifest(content.replace(b"{", b'{\n "format": 3,', 1), "m")


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
        (("scenario",), {"name": "x"}, "a scenario without tasks.axes"),
        (("scenario_digest",), "A" * 64, "64 lower-case"),
        (("cost_scale",), 0, "above 0"),
        (("cost_scale",), True, "above 0"),
        (("cost_scale",), 10**400, "above 0"),
        (("domain", "axes", "speed"), [0.1, 0.1, 0.9, 1.3, 1.7, 2.1], "each above the one before"),
        (("domain", "axes", "speed"), ["0.1"], "each above the one before"),
        (("domain", "axes", "slope"), [0.1], "unknown field 'slope'"),
        (("domain", "axes"), {"speed": [0.1]}, "missing field 'cycle_duration'"),
        (("domain", "feasible"), [[True]], "shape (6, 4)"),
        (("domain", "feasible"), [[True] * 4] * 7, "a list of 1 to 6 items"),
        (("domain", "feasible", 0, 0), 1, "booleans"),
        (("domain", "feasible", 0, 0), [True], "booleans"),
        (("dataset",), {"name": "quickstart"}, "missing field 'version'"),
        (("dataset", "version"), 1, "must be text"),
        (("gaits", 1, "name"), "walking", "different names"),
        (("gaits", 1, "pattern"), "0110", "2 legs and 4 phases"),
        (("gaits", 1, "pattern"), "011/110", "2 legs and 4 phases"),
        (("gaits", 1, "key"), "01x/110", "row of digits"),
        (("scenario", "tasks"), {}, "without tasks.axes"),
        (("scenario", "transcription"), {"phases": 4}, "a scenario without transcription.knots_per_phase"),
        (("scenario", "tasks", "axes", "cycle_duration"), 0.6, "unknown field 'cycle_duration'"),
        (("scenario", "tasks", "axes", "height"), 1.0, "m.scenario.tasks.axes.height"),
        (("scenario", "tasks", "axes", "slope"), "steep", "m.scenario.tasks.axes.slope = 'steep'"),
        (("scenario", "tasks", "axes", "slope"), 90.0, "a sound tasks.axes"),
        (("scenario", "transcription", "phases"), 10**9, "transcription.phases = 1000000000: does not fit maximum 12"),
        (
            ("scenario", "transcription", "knots_per_phase"),
            True,
            "transcription.knots_per_phase = True: must be of the type integer",
        ),
        (("scenario", "transcription", "grading"), 3.0, "transcription.grading = 3.0: does not fit maximum 1"),
        (("scenario", "transcription", "forces"), None, "transcription.forces = None: must be of the type string"),
        (("scenario", "robot", "dimension"), 4, "robot.dimension = 4: does not fit enum [2, 3]"),
        (("scenario", "robot", "mass"), -1.0, "robot.mass = -1.0: does not fit exclusiveMinimum 0"),
        (("scenario", "robot", "legs"), ["F", 2], "robot.legs[0] = 'F': must be of the type object"),
        (
            ("scenario", "objective"),
            {"force": "much"},
            "m.scenario.objective.force = 'much': must be of the type number",
        ),
        (("scenario", "objective", "force"), 10**400, "must be of the type number"),
        (("scenario", "robot", "name"), "half cheetah", "does not fit pattern"),
        (("scenario", "robot", "name"), "half_cheetah\n", "does not fit pattern"),
        (("scenario", "robot", "inertia"), [[None]], "robot.inertia[0][0] = None: must be of the type number"),
        (("scenario", "robot", "wheels"), 4, "robot.wheels: is an unknown field"),
        (("scenario", "strategy"), [], "strategy = []: must be of the type object"),
        (("scenario", "stances_per_leg"), True, "stances_per_leg = True"),
        (("scenario", "name"), 3, "name = 3: must be of the type string"),
        (("scenario", "tasks", "axes", "speed"), {"start": 0.0}, "tasks.axes.speed.stop: is missing"),
        (("domain", "axes", "speed"), [0.1, 0.5, 0.9, 1.3, 1.7, 1e200], "must be values in"),
        (("cost_scale",), 1e200, "above 0"),
        (("classifier",), {}, "missing field 'kind'"),
        (("metrics",), [], "must be an object"),
        (("metrics",), [{"a": [{"b": ["c" * 30] * 6}] * 4}] * 6, "must be an object"),
        (("solver", "options"), {"a\n\x1b": 1}, r"options.a\n\x1b: an artifact may not set this option"),
        (("files", "README.md", "bytes"), -1, "an integer from 0"),
        (("files", "warmstarts.safetensors", "bytes"), LIMITS["warmstarts.safetensors"] + 1, "an integer from 0"),
        (("files", "README.md", "sha256"), "0" * 63, "64 lower-case"),
        (("solver", "options"), {"max_iter": -1}, "m.solver.options.max_iter = -1: must be an integer from 0"),
        (
            ("solver", "options"),
            {"max_iter": 10**9},
            "max_iter = 1000000000: must be an integer from 0 to 1000",
        ),
        (("gaits", 0, "name"), "trot\n\x1b[31m", "must be text of 1 to 200 printable characters"),
        (("scenario", "robot", "mass"), 1e299, "m.scenario.robot.mass = 1e+299: must be at most 1e+15"),
        (("scenario", "robot", "legs", 1, "default_foot"), [0.1, -1e200], "robot.legs[1].default_foot[1] = -1e+200"),
        (("scenario", "robot", "a\n\x1b"), 1, r"m.scenario.robot.'a\n\x1b': is an unknown field"),
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
    assert len(str(caught.value)) < 1000 and str(caught.value).isprintable()


@pytest.mark.parametrize("name", ["format", "version", "gaits", "domain", "files", "solver", "manifest_sha256"])
def test_a_missing_field_is_refused(data: dict, name: str) -> None:
    del data[name]
    content = json.dumps(data, sort_keys=True, indent=1).encode() if name == "manifest_sha256" else encode(data)
    with pytest.raises(ArtifactError):
        parse_manifest(content, "m")


def test_frames_travel_in_the_scenario_and_are_checked(data: dict) -> None:
    legs = [leg["name"] for leg in data["scenario"]["robot"]["legs"]]
    feet = [{"leg": leg, "link": "foot", "contact_point": [0.0, 0.0, 0.0]} for leg in legs]
    data["scenario"]["robot"]["frames"] = {"base_link": "base", "com_in_base": [0.0, 0.0, 0.1], "feet": feet}
    assert Frames.of(parse_manifest(encode(data), "m").scenario).com_in_base == (0.0, 0.0, 0.1)
    data["scenario"]["robot"]["frames"]["com_in_base"] = [0.0, 0.0]
    with pytest.raises(ArtifactError, match=r"scenario\.robot\.frames\.com_in_base"):
        parse_manifest(encode(data), "m")
