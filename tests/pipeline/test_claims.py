"""The paper's statements are measured on grids, whatever was published after them."""

from __future__ import annotations

from pathlib import Path

from gaitflow.pipeline.published import claims
from gaitflow.pipeline.workspace import Workspace

DATASETS = Path(__file__).parents[2] / "datasets"
EXACT = "half-cheetah-exact-vibration"


def test_a_version_whose_tasks_were_chosen_is_passed_over(tmp_path: Path) -> None:
    grid = next(iter(sorted((DATASETS / EXACT).iterdir())))
    folder = tmp_path / "datasets" / EXACT
    folder.mkdir(parents=True)
    (folder / "1.0.0").symlink_to(grid)
    before = claims(Workspace(tmp_path))
    assert any(claim.exact_verdict != "not measured" for claim in before)
    (folder / "1.1.0").symlink_to(DATASETS / "half-cheetah-exact-slopes/1.2.0")
    assert claims(Workspace(tmp_path)) == before
    (folder / "1.0.0").unlink()
    assert all(claim.exact_verdict == "not measured" for claim in claims(Workspace(tmp_path)))
