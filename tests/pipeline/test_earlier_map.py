"""Which map a sampling may begin with, and that it is kept for when the sampling goes on."""

from __future__ import annotations

from pathlib import Path

import pytest

from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.pipeline.earlier_map import earlier_atlas, keep_earlier
from gaitflow.pipeline.workspace import Run
from gaitflow.problem import transcribe
from gaitflow.runtime import ArtifactError
from gaitflow.runtime.artifact import load_artifact
from gaitflow.runtime.versions import resolve

ROOT = Path(__file__).parents[2]
NAME = "half-cheetah-exact-slopes"
MAP, DATASETS = ROOT / "models" / NAME, ROOT / "datasets"


def scenario(name: str = NAME) -> Scenario:
    return load_scenario(ROOT / "configs" / "scenarios" / f"{name}.yaml")


def test_the_atlas_that_was_kept_is_read_again(tmp_path: Path) -> None:
    run = Run(tmp_path)
    assert earlier_atlas(run, scenario(), transcribe(scenario())) is None
    for _ in range(2):  # the same command goes on
        keep_earlier(run, scenario(), MAP, DATASETS / NAME)
    kept, published = earlier_atlas(run, scenario(), transcribe(scenario())), load_artifact(resolve(MAP)).atlas
    assert kept is not None and [one.pattern for one in kept.sheets] == [one.pattern for one in published.sheets]
    for one, other in zip(kept.sheets, published.sheets, strict=True):
        assert one.tasks.tobytes() == other.tasks.tobytes() and one.costs.tobytes() == other.costs.tobytes()
        assert one.coordinates.tobytes() == other.coordinates.tobytes() and one.gait == 0


def test_a_map_of_another_problem_is_refused(tmp_path: Path) -> None:
    for other in ("half-cheetah-exact-vibration", "half-cheetah-flat-vibration", "anymal-slopes"):
        with pytest.raises(ValueError, match=f"of another problem or other axes than {NAME}"):
            keep_earlier(Run(tmp_path), scenario(), ROOT / "models" / other, DATASETS / NAME)
    assert not any(tmp_path.iterdir())


def test_a_map_that_learnt_more_than_the_dataset_is_refused(tmp_path: Path) -> None:
    earlier, other = DATASETS / NAME / "1.2.0", DATASETS / "anymal-slopes"
    for dataset in (earlier, other):
        with pytest.raises(ValueError, match=rf"was learnt from the dataset {NAME} 1\.3\.0; begin from that one"):
            keep_earlier(Run(tmp_path), scenario(), MAP, dataset)


def test_a_sampling_that_began_without_the_map_goes_on_without(tmp_path: Path) -> None:
    run = Run(tmp_path)
    run.rounds.parent.mkdir()
    run.rounds.write_text("[]")
    with pytest.raises(ValueError, match="has begun already, and not with this map; leave --map away"):
        keep_earlier(run, scenario(), MAP, DATASETS / NAME)


def test_a_damaged_copy_is_named(tmp_path: Path) -> None:
    run = Run(tmp_path)
    keep_earlier(run, scenario(), MAP, DATASETS / NAME)
    run.earlier_atlas.write_bytes(run.earlier_atlas.read_bytes()[:-9])
    with pytest.raises(ArtifactError, match="earlier"):
        earlier_atlas(run, scenario(), transcribe(scenario()))
