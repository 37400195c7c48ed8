from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from gaitflow.publishing import newest, published
from gaitflow.runtime.versions import Version


def test_order_is_semantic_not_alphabetical(tmp_path: Path) -> None:
    for name in ("1.9.0", "1.10.0", "0.99.99", "1.9.12"):
        (tmp_path / name).mkdir()
    assert [str(one.version) for one in published(tmp_path)] == ["0.99.99", "1.9.0", "1.9.12", "1.10.0"]
    assert newest(tmp_path).path == tmp_path / "1.10.0"


def test_what_is_no_version_folder_is_not_listed(tmp_path: Path) -> None:
    for name in (".1.0.0.77-abc", "latest", "1.0", "1.0.0rc"):
        (tmp_path / name).mkdir()
    (tmp_path / "2.0.0").touch()
    assert published(tmp_path) == ()
    assert newest(tmp_path) is None


def test_no_folder_no_versions(tmp_path: Path) -> None:
    assert published(tmp_path / "none") == ()


def test_creation_time_is_listed_and_none_for_a_damaged_version(pristine: Path, tmp_path: Path) -> None:
    shutil.copytree(pristine, tmp_path / "1.0.0")
    (tmp_path / "1.1.0").mkdir()
    sound, damaged = published(tmp_path)
    assert sound.created is not None
    assert sound.created.tzinfo is not None
    assert damaged.created is None


@pytest.mark.parametrize("text", ["1.2", "1.2.3.4", "1.02.3", "a.b.c", "1.2.3\n", "1.2.-3", "9999999999.0.0", "١.0.0"])
def test_text_that_is_no_version(text: str) -> None:
    with pytest.raises(ValueError, match="write <major>"):
        Version.parse(text)


def test_text_of_a_version_round_trips() -> None:
    assert str(Version.parse("10.20.30")) == "10.20.30"
