"""An export is made of a sound map, whole, the same each time, and of maps without an atlas, too."""

from __future__ import annotations

from pathlib import Path

import pytest

from gaitflow.export import CannotExport, Exported, export_c
from gaitflow.export.export import CONTENT
from gaitflow.runtime import ArtifactError

MODELS = Path(__file__).parents[2] / "models"


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_the_newest_version_is_exported_the_same_each_time(exported: Exported, tmp_path: Path) -> None:
    again = export_c(exported.model.parent, tmp_path / "again")
    assert again.model == exported.model
    assert content(again.folder) == content(exported.folder)
    assert sorted(content(again.folder)) == sorted(CONTENT)
    assert again.sizes == {name: len(data) for name, data in content(again.folder).items()}
    assert export_c(exported.model, tmp_path / "again").sizes == again.sizes


def test_a_map_of_before_there_were_atlases_has_none(checkout: Path, tmp_path: Path) -> None:
    model = checkout / "models/half-cheetah-flat-effort/1.0.0"
    with pytest.raises(ArtifactError, match=r"problem.casadi: .* holds its problem as code"):
        export_c(model, tmp_path / "old")
    assert not (tmp_path / "old").exists()
    done = export_c(model, tmp_path / "old", trust_code=True)
    assert done.sizes["map.bin"] < 1_000_000
    assert (done.folder / "map.bin").read_bytes().endswith(bytes(8)), "no sheets"


@pytest.mark.parametrize(
    "name", ["classifier.onnx", "problem_check.safetensors", "warmstarts.safetensors", "atlas.safetensors"]
)
def test_of_a_damaged_map_nothing_is_written(artifact: Path, tmp_path: Path, name: str) -> None:
    (artifact / name).write_bytes((artifact / name).read_bytes()[:-1])
    with pytest.raises(ArtifactError, match=name):
        export_c(artifact, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
@pytest.mark.parametrize("scenario", sorted(path.name for path in MODELS.iterdir() if path.is_dir()))
def test_every_published_map_can_be_exported(scenario: str, tmp_path: Path) -> None:
    done = export_c(MODELS / scenario, tmp_path / "c")
    assert sorted(content(done.folder)) == sorted(CONTENT)


def test_a_place_that_is_taken_is_refused_before_the_map_is_read(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(CannotExport, match=r"notes\.txt"):
        export_c(tmp_path / "no such map", tmp_path)
