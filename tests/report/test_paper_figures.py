"""The paper's figures from the published datasets and maps."""

from __future__ import annotations

from pathlib import Path

import pytest

from gaitflow.report.claims import EXACT
from gaitflow.report.paper_figures import FIG_9, PublishedMap, write_paper_figures

CHECKOUT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def space() -> PublishedMap:
    return PublishedMap.load(EXACT["7"], CHECKOUT / "datasets", CHECKOUT / "models")


def test_a_gait_has_one_name_in_the_labels_and_in_the_map(space: PublishedMap) -> None:
    named = {gait.name for gait in space.gait_map.gaits}
    on_grid = space.labels[space.labels["split"] == "grid"]
    assert set(on_grid["gait"]) <= named
    legend = [text.get_text() for text in space.map().legends[0].get_texts()]
    assert len(legend) == len(named | set(space.labels["gait"])) + 3, "a line a gait, and three for the marks"


@pytest.mark.parametrize("beginning", FIG_9)
def test_the_snapshots_of_figure_9_have_their_gaits(space: PublishedMap, beginning: str) -> None:
    assert space.motion(beginning).axes[0].get_title(loc="left").startswith(beginning)


def test_what_is_not_published_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"half-cheetah-flat-effort: no published version; the figures need those of"):
        next(write_paper_figures(tmp_path / "figures", tmp_path, tmp_path))
    assert not (tmp_path / "figures").exists()


@pytest.mark.slow
def test_every_figure_is_drawn_twice(tmp_path: Path) -> None:
    written = [path.name for path in write_paper_figures(tmp_path, CHECKOUT / "datasets", CHECKOUT / "models")]
    figures = ("4a", "4b", "4c", "5", "6", "7", "8", "9-1", "9-2", "9-3", "9-4", "10")
    assert written == [f"fig-{figure}-{rule}.png" for rule in ("euler", "exact") for figure in figures]
    assert all((tmp_path / name).stat().st_size > 20_000 for name in written)
