from __future__ import annotations

import errno
import json
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tiny_map import linear_classifier, scenario_of

from gaitflow.config.scenario import Range
from gaitflow.files import WriteError
from gaitflow.problem import transcribe
from gaitflow.publishing import Parts, PublishError, VersionExists, newest, publish, published, verify, versioned_folder
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.manifest_file import read_manifest
from gaitflow.runtime.problem_check import parse_problem_check


def test_first_version_is_sound_and_named_by_the_scenario(tmp_path: Path, parts: Parts) -> None:
    path = publish(tmp_path, parts)
    assert path == tmp_path / "quickstart" / "1.0.0"
    assert verify(path) == []
    assert [entry.name for entry in path.parent.iterdir()] == ["1.0.0"], "nothing temporary is left"


def test_manifest_lists_what_was_given(pristine: Path, parts: Parts) -> None:
    manifest = read_manifest(pristine)
    assert manifest.name == "quickstart"
    assert [gait.name for gait in manifest.gaits] == ["walking", "gallop"]
    assert manifest.gaits[1].pattern == "0110/1100"
    assert manifest.layout == parts.problem.layout
    assert manifest.dataset == {"name": "quickstart", "version": "1.0.0"}
    assert np.array_equal(manifest.domain.feasible, parts.feasible)
    assert manifest.metrics["accuracy"] == 0.97
    assert manifest.solver_options == {"max_iter": 200, "mumps_pivot_order": 0}


def test_same_content_is_not_published_twice(tmp_path: Path, parts: Parts) -> None:
    first = publish(tmp_path, parts)
    again = publish(tmp_path, replace(parts, code={"commit": "another"}))
    assert again == first
    assert len(published(first.parent)) == 1


@pytest.mark.parametrize("change", ["classifier", "atlas", "metrics", "dataset", "feasible"])
def test_changed_content_takes_the_next_version(tmp_path: Path, parts: Parts, galloping: Parts, change: str) -> None:
    changed = {
        "classifier": galloping,
        "atlas": replace(parts, atlas=parts.atlas.of([0])),
        "metrics": replace(parts, metrics={"accuracy": 0.5}),
        "dataset": replace(parts, dataset={"name": "quickstart", "version": "1.1.0"}),
        "feasible": replace(parts, feasible=np.ones_like(parts.feasible)),
    }[change]
    first = publish(tmp_path, parts)
    assert publish(tmp_path, changed) == first.with_name("1.1.0")
    assert newest(first.parent).version == (1, 1, 0)


def test_damaged_newest_version_is_not_taken_for_the_same(tmp_path: Path, parts: Parts) -> None:
    first = publish(tmp_path, parts)
    (first / "README.md").write_text("edited", encoding="utf-8")
    assert publish(tmp_path, parts) == first.with_name("1.1.0")


def test_publishing_over_a_version_is_refused_and_changes_nothing(artifact: Path, galloping: Parts) -> None:
    before = {file.name: file.read_bytes() for file in artifact.iterdir()}
    with pytest.raises(VersionExists, match=r"1\.0\.0 is published already.*leave the version out"):
        publish(artifact.parents[1], galloping, "1.0.0")
    assert {file.name: file.read_bytes() for file in artifact.iterdir()} == before
    assert [entry.name for entry in artifact.parent.iterdir()] == ["1.0.0"]


def test_losing_a_race_for_a_version_keeps_the_winner(artifact: Path, galloping: Parts, monkeypatch) -> None:
    # The look before publishing comes too early to see the other writer; the rename must see it.
    checks = iter([lambda target: None])
    real = versioned_folder._refuse_taken
    monkeypatch.setattr(versioned_folder, "_refuse_taken", lambda target: next(checks, real)(target))
    before = (artifact / "manifest.json").read_bytes()
    with pytest.raises(VersionExists):
        publish(artifact.parents[1], galloping, "1.0.0")
    assert (artifact / "manifest.json").read_bytes() == before
    assert [entry.name for entry in artifact.parent.iterdir()] == ["1.0.0"]


def test_concurrent_publishers_all_get_a_version_of_their_own(tmp_path: Path, parts: Parts) -> None:
    results: list[Path] = []
    variants = [replace(parts, metrics={"accuracy": value}) for value in (0.1, 0.2, 0.3)]
    threads = [threading.Thread(target=lambda one=one: results.append(publish(tmp_path, one))) for one in variants]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(path.name for path in results) == ["1.0.0", "1.1.0", "1.2.0"]
    assert {read_manifest(path).metrics["accuracy"] for path in results} == {0.1, 0.2, 0.3}


@pytest.mark.parametrize("version", ["1.0", "v1.0.0", "01.0.0", "1.0.0-rc1", "../1.0.0", ""])
def test_bad_version_is_refused(tmp_path: Path, parts: Parts, version: str) -> None:
    with pytest.raises(ValueError, match=r"write <major>\.<minor>\.<patch>"):
        publish(tmp_path, parts, version)
    assert list(tmp_path.iterdir()) == []


def test_unsound_parts_publish_nothing(tmp_path: Path, parts: Parts) -> None:
    short = replace(parts, starts=parts.starts[:1], classes=parts.classes[:1], atlas=parts.atlas.of([0]))
    with pytest.raises(PublishError, match=r"classifier\.onnx: probability must be finite with shape \(1, 1\)"):
        publish(tmp_path, short)
    assert list((tmp_path / "quickstart").iterdir()) == []


def test_starts_follow_the_classifier_whatever_their_order(tmp_path: Path, parts: Parts) -> None:
    path = publish(tmp_path, parts)
    assert publish(tmp_path, replace(parts, starts=parts.starts[::-1])) == path


@pytest.mark.parametrize("classes", [("walking",), ("walking", "trot"), ("walking", "gallop", "gallop"), ()])
def test_classes_without_their_start_are_refused(parts: Parts, classes: tuple[str, ...]) -> None:
    with pytest.raises(PublishError, match=r"but there are starts for \['gallop', 'walking'\]"):
        replace(parts, classes=classes)


def test_sheets_of_a_gait_that_the_map_does_not_have_are_refused(parts: Parts) -> None:
    stray = replace(parts.atlas.sheets[0], gait=2)
    with pytest.raises(PublishError, match=r"2 gaits, but the atlas has sheets of \[2\]"):
        replace(parts, atlas=replace(parts.atlas, sheets=(stray,)))


def test_nodes_outside_the_domain_are_not_published(tmp_path: Path, parts: Parts) -> None:
    smaller = parts.feasible.copy()
    smaller[0, 0] = False
    with pytest.raises(
        PublishError, match=r"atlas\.safetensors: walking has a node at speed 0\.1 m/s, .* outside the map's"
    ):
        publish(tmp_path, replace(parts, feasible=smaller))


def test_a_sheet_under_another_gait_is_not_published(tmp_path: Path, parts: Parts) -> None:
    swapped = tuple(replace(sheet, gait=1 - sheet.gait) for sheet in parts.atlas.sheets)
    with pytest.raises(PublishError, match=r"the pattern 0111/1101 of a sheet is not the gait gallop"):
        publish(tmp_path, replace(parts, atlas=replace(parts.atlas, sheets=swapped)))


def test_not_a_number_in_the_metrics_is_refused(tmp_path: Path, parts: Parts) -> None:
    with pytest.raises(PublishError, match="plain JSON without NaN"):
        publish(tmp_path, replace(parts, metrics={"accuracy": float("nan")}))


def test_solver_options_that_open_files_are_refused(tmp_path: Path, parts: Parts) -> None:
    with pytest.raises(PublishError, match=r"solver\.options\.hsllib: an artifact may not set"):
        publish(tmp_path, replace(parts, solver_options={"hsllib": "evil.so"}))


def test_a_disk_that_fills_leaves_nothing_behind(tmp_path: Path, parts: Parts, monkeypatch) -> None:
    real = versioned_folder.atomic_write

    def full(path: Path, data: bytes) -> None:
        if path.name == "warmstarts.safetensors":
            raise WriteError(errno.ENOSPC, f"{path}: cannot be written (No space left on device)")
        real(path, data)

    monkeypatch.setattr(versioned_folder, "atomic_write", full)
    with pytest.raises(WriteError, match="No space left"):
        publish(tmp_path, parts)
    assert list((tmp_path / "quickstart").iterdir()) == []


def test_manifest_is_readable_json_with_the_scenario_whole(pristine: Path, parts: Parts) -> None:
    data = json.loads((pristine / "manifest.json").read_text(encoding="utf-8"))
    assert data["scenario"] == parts.problem.scenario.as_data()
    assert data["format"] == 3
    assert data["domain"]["axes"]["cycle_duration"] == list(parts.domain.axes["cycle_duration"])


def test_what_is_stored_of_the_problem_holds_every_term(pristine: Path, parts: Parts) -> None:
    """A problem that differs anywhere shows it: no row of the three points is 0 by chance."""
    problem = parts.problem
    content = (pristine / "problem_check.safetensors").read_bytes()
    stored = parse_problem_check(content, problem.layout, problem.ng, "check")
    assert stored.differs(problem.nlp) is None
    assert len({tuple(task) for task in stored.tasks.tolist()}) == 3
    assert (np.abs(stored.rows).max(axis=0) > 1e-9).mean() > 0.99
    scenario = problem.scenario
    heavier = scenario.robot.model_copy(update={"mass": scenario.robot.mass * (1 + 1e-6)})
    other = transcribe(scenario.model_copy(update={"robot": heavier}))
    assert stored.differs(other.nlp) is not None


def test_a_map_over_three_axes_is_published(tmp_path: Path, parts: Parts) -> None:
    scenario = scenario_of(slope=Range(start=-5.0, stop=5.0, count=2))
    problem = transcribe(scenario)
    shape = tuple(values.count for values in scenario.tasks.ranges.values())
    three = replace(
        parts,
        problem=problem,
        feasible=np.ones(shape, dtype=bool),
        classifier=linear_classifier([-5.0, 5.0], [3.5, -3.5], axes=3),
        atlas=Atlas.empty(tuple(scenario.tasks.ranges)),
    )
    path = publish(tmp_path, three)
    assert tuple(read_manifest(path).domain.axes) == ("speed", "cycle_duration", "slope")
    assert "| slope | -5 to 5 (2 values) deg |" in (path / "README.md").read_text(encoding="utf-8")
