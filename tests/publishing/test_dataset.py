"""A published dataset: its version is its own, and no damage goes unseen."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from shutil import copytree

import pandas as pd
import pytest
from small_units import PATTERNS, solutions_of

from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.config.tasks import tasks_of
from gaitflow.dataset import load_solutions
from gaitflow.dataset.collect import collect
from gaitflow.dataset.labels import gait_costs, label_tasks
from gaitflow.publishing import dataset as module
from gaitflow.publishing.dataset import FILES, content_digest, publish_dataset, read_manifest
from gaitflow.publishing.dataset_facts import LABELS
from gaitflow.publishing.verify_dataset import verify_dataset
from gaitflow.publishing.versioned_folder import VersionExists, file_faults
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import plan_units

PUBLISHED = "tests/data/datasets/half-cheetah-slope20-vibration/1.0.0"  # four tasks of it


@pytest.fixture
def run(checkout: Path, tmp_path: Path) -> tuple[Path, Path, Path]:
    """A collected run, with labels and costs that say that one gait wins everywhere."""
    data = load_scenario(checkout / "configs/scenarios/quickstart.yaml").as_data()
    data["transcription"]["knots_per_phase"] = 2
    data["tasks"]["axes"]["speed"] = {"start": 0.1, "stop": 2.1, "count": 2}
    data["tasks"]["held_out"] = 0
    scenario, store = Scenario.from_data(data, "test"), UnitStore(tmp_path / "run")
    for unit in plan_units(scenario):
        store.write(unit, solutions_of(unit), {})
    collected = collect(store, scenario)
    labels, costs = tmp_path / "labels.parquet", tmp_path / "gait_costs.parquet"
    known = gait_costs(load_solutions(collected).frame(), scenario.robot.leg_names)
    known.to_parquet(costs)
    label_tasks(known, tasks_of(scenario), 1e-3, 2).to_parquet(labels)
    return collected, labels, costs


def test_the_same_content_is_published_once(run: tuple[Path, Path, Path], tmp_path: Path) -> None:
    collected, labels, costs = run
    datasets = tmp_path / "datasets"
    first = publish_dataset(datasets, collected, labels, costs)
    assert first == datasets / "quickstart/1.0.0" and {path.name for path in first.iterdir()} == {
        *FILES,
        "manifest.json",
    }
    assert publish_dataset(datasets, collected, labels, costs) == first
    pd.read_parquet(labels).assign(label="walking").to_parquet(labels)
    assert publish_dataset(datasets, collected, labels, costs) == datasets / "quickstart/1.1.0"
    with pytest.raises(VersionExists):
        publish_dataset(datasets, collected, labels, costs, "1.0.0")
    assert publish_dataset(datasets, collected, labels, costs, "2.0.0").name == "2.0.0"


def test_one_more_asking_for_a_certificate_is_another_content(run: tuple[Path, Path, Path]) -> None:
    """Whoever begins from the dataset would count one too few."""
    record, labels = load_solutions(run[0]).record, pd.read_parquet(run[1])
    contents = {content_digest({**record, **asked}, labels) for asked in ({}, {"askings": 1}, {"askings": 2})}
    assert len(contents) == 3


def test_the_published_rows_keep_the_motions_of_the_best(run: tuple[Path, Path, Path], tmp_path: Path) -> None:
    collected, labels, costs = run
    folder = publish_dataset(tmp_path / "datasets", collected, labels, costs)
    whole, small = load_solutions(collected), load_solutions(folder)
    assert small.record == whole.record and len(small) == len(whole)
    kept = [row for row in small if row.trajectory is not None]
    assert len(kept) == len(pd.read_parquet(labels)) and all(row.multipliers is not None for row in kept)
    card = (folder / "README.md").read_text()
    assert "over speed, cycle_duration" in card and "at most 15% dearer" in card and "| grid | " in card
    assert not list(collected.parent.glob("tmp*"))


def test_a_large_file_keeps_fewer_motions(
    run: tuple[Path, Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    collected, labels, costs = run
    cheap = pd.read_parquet(costs)
    three = pd.concat([cheap.assign(excess=0.0, pattern=pattern) for pattern in PATTERNS])
    three.to_parquet(costs)
    kept = {}
    for bytes_allowed in (10**9, 1):
        monkeypatch.setattr(module, "LARGE", bytes_allowed)
        folder = publish_dataset(tmp_path / str(bytes_allowed), collected, labels, costs)
        kept[bytes_allowed] = sum(row.trajectory is not None for row in load_solutions(folder))
    assert kept[1] < kept[10**9] and kept[1] > 0, "the best of each task at least"


def test_a_sound_dataset_has_no_fault_and_a_wrong_motion_is_one(checkout: Path, run: tuple[Path, Path, Path]) -> None:
    assert verify_dataset(checkout / PUBLISHED) == []
    collected, labels, costs = run
    faults = verify_dataset(publish_dataset(collected.parent / "datasets", collected, labels, costs))
    assert faults and all(fault.file == "solutions.parquet" for fault in faults)
    assert "speed 0.1 m/s, cycle_duration 0.4 s, pattern 0110/1100: violates a constraint by" in str(faults[0])


def flip(path: Path) -> None:
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)


def edit(path: Path, change: Callable[[dict[str, object]], object]) -> None:
    data = json.loads(path.read_text())
    change(data)
    path.write_text(json.dumps(data))


@pytest.mark.parametrize(
    ("damage", "told"),
    [
        (lambda folder: flip(folder / LABELS), "labels.parquet: its content is not what the manifest lists"),
        (lambda folder: (folder / LABELS).unlink(), "labels.parquet: "),
        (lambda folder: (folder / "more").write_text("x"), "more: does not belong"),
        (lambda folder: (folder / "manifest.json").unlink(), "manifest.json: .*no readable manifest"),
        (lambda folder: (folder / "manifest.json").write_text("[1]"), "manifest.json: .*no readable manifest"),
        (lambda folder: edit(folder / "manifest.json", lambda data: data.update(format=9)), "has format 9"),
        (
            lambda folder: edit(folder / "manifest.json", lambda data: data["files"].pop(LABELS)),
            "labels.parquet: is missing from the manifest",
        ),
    ],
)
def test_damage_is_named(checkout: Path, tmp_path: Path, damage: Callable[[Path], object], told: str) -> None:
    folder = copytree(checkout / PUBLISHED, tmp_path / "1.1.0")
    damage(folder)
    assert any(re.search(told, str(finding)) for finding in verify_dataset(folder))


def test_manifests_of_published_datasets_are_read(checkout: Path) -> None:
    for folder in (checkout / "datasets").glob("*/*"):
        if folder.is_dir():
            manifest = read_manifest(folder)
            assert (manifest.scenario, manifest.version) == (folder.parent.name, folder.name)


def test_no_file_of_a_shipped_dataset_has_changed(checkout: Path) -> None:
    folders = [path.parent for path in sorted((checkout / "datasets").glob("*/*/manifest.json"))]
    folders = [folder for folder in folders if folder.parent.name != "quickstart"]  # `make run` publishes it here
    assert len(folders) > 10
    for folder in folders:
        assert file_faults(folder, read_manifest(folder).files) == [], folder
