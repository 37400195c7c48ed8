"""A folder appears whole or not at all, and takes the place of nothing but an earlier export."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from gaitflow.export.folder import write_folder
from gaitflow.export.graph import CannotExport
from gaitflow.files import WriteError

FILES = {"a": b"1", "b": b"2"}


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_a_new_an_empty_and_an_earlier_folder_are_written(tmp_path: Path) -> None:
    for folder in (tmp_path / "deep" / "new", tmp_path / "empty"):
        (tmp_path / "empty").mkdir(exist_ok=True)
        write_folder(folder, FILES)
        assert content(folder) == FILES
        write_folder(folder, {**FILES, "b": b"3"})
        assert content(folder) == {"a": b"1", "b": b"3"}
        assert [entry.name for entry in folder.parent.iterdir() if entry.name.startswith(".")] == []


def test_what_is_no_export_stays(tmp_path: Path) -> None:
    folder, file, link = tmp_path / "mine", tmp_path / "file", tmp_path / "link"
    write_folder(folder, FILES)
    (folder / "thesis.tex").write_bytes(b"years")
    file.write_bytes(b"")
    link.symlink_to(tmp_path / "nowhere")
    with pytest.raises(CannotExport, match=r"mine: holds 'thesis.tex'.*give the name of a new folder"):
        write_folder(folder, {"a": b"new", "b": b"new"})
    assert content(folder) == {**FILES, "thesis.tex": b"years"}
    for taken in (file, link):
        with pytest.raises(CannotExport, match="is not a folder; give the name of a new one"):
            write_folder(taken, FILES)
    assert sorted(os.listdir(tmp_path)) == ["file", "link", "mine"]


@pytest.mark.parametrize("failing", [1, 2])
def test_a_write_that_fails_leaves_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failing: int
) -> None:
    folder = tmp_path / "out"
    write_folder(folder, FILES)
    rename, renames = os.rename, []

    def full(source: Path, target: Path) -> None:
        renames.append(target)
        if len(renames) == failing:
            raise OSError(28, "No space left on device")
        rename(source, target)

    monkeypatch.setattr(os, "rename", full)
    with pytest.raises(WriteError, match=r"out: cannot be written \(No space left on device\)"):
        write_folder(folder, {"a": b"new", "b": b"new"})
    assert content(folder) == FILES
    assert os.listdir(tmp_path) == ["out"]


def test_a_disk_that_refuses_a_file_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(WriteError, match="file"):
        write_folder(tmp_path / "file" / "out", FILES)
    assert os.listdir(tmp_path) == ["file"]
