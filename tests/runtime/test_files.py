from __future__ import annotations

import os
from pathlib import Path

import pytest

from gaitflow.runtime import ArtifactError, GaitMap
from gaitflow.runtime.files import CARD, CONTENT, LIMITS, MANIFEST, entry_of, read_checked, read_limited


def test_a_file_over_the_limit_is_refused_unread(tmp_path: Path) -> None:
    path = tmp_path / "big"
    with open(path, "wb") as file:
        file.truncate(1 << 40)  # sparse: reading it would take a terabyte of memory
    with pytest.raises(ArtifactError, match=r"1099511627776 bytes; this file may have at most 1000"):
        read_limited(path, 1000)


@pytest.mark.parametrize("name", [MANIFEST, *(name for name in CONTENT if name != CARD)])
def test_an_oversized_file_of_an_artifact_is_refused_unread(artifact: Path, name: str) -> None:
    os.truncate(artifact / name, LIMITS[name] + (1 << 40))
    with pytest.raises(ArtifactError, match=rf"{name}: \d+ bytes; this file may have at most"):
        GaitMap.load(artifact).plan(0.9, 0.6)


def test_links_and_pipes_are_refused(tmp_path: Path) -> None:
    (tmp_path / "real").write_bytes(b"x")
    (tmp_path / "link").symlink_to("real")
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    for name in ("link", "pipe", "folder", "missing"):
        with pytest.raises(ArtifactError, match=name):
            read_limited(tmp_path / name, 10)


def test_content_is_checked_against_its_entry(tmp_path: Path) -> None:
    path = tmp_path / "README.md"
    entry = entry_of(b"text")
    path.write_bytes(b"text")
    assert read_checked(tmp_path, "README.md", entry) == b"text"
    for wrong in (b"tex", b"texT", b""):
        path.write_bytes(wrong)
        with pytest.raises(ArtifactError, match="not what the manifest lists"):
            read_checked(tmp_path, "README.md", entry)
    path.write_bytes(b"text longer")
    with pytest.raises(ArtifactError, match="11 bytes; this file may have at most 4"):
        read_checked(tmp_path, "README.md", entry)
