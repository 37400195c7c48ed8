"""The page that shows Euler's maps beside the exact ones."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from gaitflow.report.exact_motion import PAGE, published_map, write_exact_motion


@pytest.fixture
def datasets(checkout: Path, tmp_path: Path) -> Path:
    """Two published maps of the paper, one of them in the place of an exact one."""
    folder = tmp_path / "datasets"
    places = {"half-cheetah-flat-vibration": "half-cheetah-flat-vibration"}
    places["half-cheetah-exact-vibration"] = "half-cheetah-slope20-vibration"
    for name, source in places.items():
        shutil.copytree(checkout / "datasets" / source / "1.0.0", folder / name / "1.0.0")
    return folder


def test_pairs_that_are_published_are_drawn_and_counted(datasets: Path, tmp_path: Path) -> None:
    docs = tmp_path / "docs"
    written = write_exact_motion(datasets, docs)
    picture = docs / "images" / "exact-half-cheetah-flat-vibration.png"
    assert written == [picture, docs / "results" / PAGE]
    assert picture.read_bytes().startswith(b"\x89PNG")
    page = (docs / "results" / PAGE).read_text(encoding="utf-8")
    (row,) = [
        line for line in page.splitlines() if line.startswith("| half-cheetah-flat-vibration / half-cheetah-exact-v")
    ]
    told = [cell.strip() for cell in row.strip("|").split("|")]
    assert told[1] == "124" and 0 < int(told[3]) <= int(told[2]) < 124 and told[5].endswith("%")
    assert "(../images/exact-half-cheetah-flat-vibration.png)" in page
    assert "half-cheetah-flat-effort" not in page


def test_without_a_pair_there_is_no_page(datasets: Path, tmp_path: Path) -> None:
    shutil.rmtree(datasets / "half-cheetah-exact-vibration")
    assert published_map(datasets / "half-cheetah-exact-vibration") is None
    with pytest.raises(ValueError, match="publish one of each first"):
        write_exact_motion(datasets, tmp_path / "docs")
    assert not (tmp_path / "docs").exists()
