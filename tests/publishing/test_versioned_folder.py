"""A published folder appears whole or not at all, under a version that nobody else has, and damage to it is found."""

from __future__ import annotations

from pathlib import Path

import pytest

from gaitflow.publishing.versioned_folder import (
    PublishError,
    VersionExists,
    file_faults,
    listed,
    next_version,
    publish_folder,
    publish_next,
)
from gaitflow.runtime.files import entry_of

FILES = {"manifest.json": b"{}", "data.bin": b"1234"}


def test_folder_holds_the_files_and_nothing_else_is_left(tmp_path: Path) -> None:
    folder = publish_folder(tmp_path / "map", "1.0.0", FILES)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == FILES
    assert [path.name for path in (tmp_path / "map").iterdir()] == ["1.0.0"]


def test_a_published_version_never_changes(tmp_path: Path) -> None:
    folder = publish_folder(tmp_path, "1.0.0", FILES)
    with pytest.raises(VersionExists, match="never changes"):
        publish_folder(tmp_path, "1.0.0", {"data.bin": b"other"})
    assert (folder / "data.bin").read_bytes() == b"1234"


def test_what_inspection_finds_is_not_published(tmp_path: Path) -> None:
    def inspect(folder: Path) -> list[str]:
        return [f"{path.name} is odd" for path in folder.iterdir() if path.name == "data.bin"]

    with pytest.raises(PublishError, match=r"data\.bin is odd"):
        publish_folder(tmp_path / "map", "1.0.0", FILES, inspect)
    assert list((tmp_path / "map").iterdir()) == []


def test_a_version_is_a_number_not_a_path(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="write <major>"):
        publish_folder(tmp_path / "map", "../1.0.0", FILES)


def test_next_version_is_the_minor_after_the_newest(tmp_path: Path) -> None:
    assert str(next_version(tmp_path)) == "1.0.0"
    for version in ("1.9.0", "1.10.0"):
        publish_folder(tmp_path, version, FILES)
    assert str(next_version(tmp_path)) == "1.11.0"


def test_publish_next_takes_another_number_when_one_was_taken_meanwhile(tmp_path: Path) -> None:
    asked: list[str] = []

    def make(version: str) -> Path:
        if not asked:
            publish_folder(tmp_path, version, FILES)  # somebody else, in between
        asked.append(version)
        return publish_folder(tmp_path, version, FILES)

    assert publish_next(tmp_path, make).name == "1.1.0"
    assert asked == ["1.0.0", "1.1.0"]


def test_faults_name_what_is_missing_foreign_or_damaged(tmp_path: Path) -> None:
    content = {"a": b"1", "b": b"2", "c": b"3"}
    folder = publish_folder(tmp_path, "1.0.0", content)
    entries = {name: entry_of(data) for name, data in content.items()}
    assert file_faults(folder, entries) == []
    (folder / "a").write_bytes(b"x")
    (folder / "b").unlink()
    (folder / "d").write_bytes(b"")
    assert [fault.file for fault in file_faults(folder, entries)] == ["d", "a", "b"]


def test_list_has_digest_and_size() -> None:
    assert listed({"a": b"abc"})["a"] == {
        "sha256": "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad",
        "bytes": 3,
    }
