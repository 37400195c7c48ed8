"""A published dataset as others meet it: card, Croissant, Workflow Run Crate, and what makes it again."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import mlcroissant
import pyarrow.parquet as pq
import pytest
from rocrate.rocrate import ROCrate

from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.core.errors import ArtifactError
from gaitflow.dataset import load_solutions
from gaitflow.files import sha256_file
from gaitflow.publishing.describe import describe_dataset

# One of today's form, of a robot in space with energy, and one of before there were axes.
DATASETS = ("half-cheetah-exact-slopes/1.1.0", "go1-energy/1.0.0", "half-cheetah-flat-effort/1.0.0")


@pytest.fixture(scope="module", params=DATASETS)
def published(checkout: Path, request: pytest.FixtureRequest) -> Path:
    return checkout / "datasets" / str(request.param)


@pytest.fixture(scope="module")
def described(published: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    output = tmp_path_factory.mktemp("described") / published.parent.name
    describe_dataset(published, output)
    return output


def test_the_card_names_every_column_and_which_rows_have_a_motion(published: Path, described: Path) -> None:
    card = (described / "README.md").read_text()
    for file in ("solutions", "labels", "gait_costs"):
        section = card.split(f"### {file}\n")[1].split("\n## ")[0].split("\n### ")[0]
        rows = dict(re.findall(r"^\| `(\w+)` \| [^|]+ \| [^|]* \| [^|]* \| (.+) \|$", section, re.MULTILINE))
        assert list(rows) == pq.read_schema(published / f"{file}.parquet").names and all(rows.values())
    motions = sum(row.trajectory is not None for row in load_solutions(published))
    assert f"\n{motions} of the {len(load_solutions(published))} rows" in card
    assert "@inproceedings{wang2020automatic" in card and "BSD-3-Clause" in card
    assert all(maker["code"]["commit"] in card for maker in load_solutions(published).record["made_by"])


def test_croissant_is_valid_and_its_records_are_the_rows(described: Path) -> None:
    dataset = mlcroissant.Dataset(str(described / "croissant.json"))
    issues = dataset.metadata.ctx.issues
    assert not issues.errors and not issues.warnings
    first = next(iter(dataset.records("labels")))
    row = pq.read_table(described / "labels.parquet").slice(0, 1).to_pylist()[0]
    assert first["labels/gait"] == row["gait"].encode() and first["labels/cost"] == pytest.approx(row["cost"])
    fields = {field.name: field for records in dataset.metadata.record_sets for field in records.fields}
    shape = pq.read_schema(described / "solutions.parquet").field("feet").metadata[b"shape"].decode()
    assert fields["feet"].array_shape == shape and "[m]" in fields["feet"].description


def test_the_crate_tells_what_was_run_on_what_by_whom(published: Path, described: Path) -> None:
    crate = ROCrate(described)
    (run,) = [entity for entity in crate.get_entities() if entity.type == "CreateAction"]
    assert crate.mainEntity.id == "Snakefile" and run["instrument"] is crate.mainEntity
    assert {result.id for result in run["result"]} == {path.name for path in published.glob("*.parquet")}
    for result in run["result"]:
        assert result["sha256"] == sha256_file(described / result.id)
    commits = [maker["code"]["commit"] for maker in load_solutions(published).record["made_by"]]
    told = [one["softwareVersion"] for one in run["object"] if one.type == "SoftwareApplication"]
    assert [text.split()[1].strip(",") for text in told] == commits
    there = {path.relative_to(described).as_posix() for path in described.rglob("*") if path.is_file()}
    assert {entity.id for entity in crate.data_entities} | {"ro-crate-metadata.json"} == there


def test_the_scenario_in_it_is_the_one_that_was_solved(published: Path, described: Path) -> None:
    (file,) = (described / "configs/scenarios").iterdir()
    solved = Scenario.from_data(load_solutions(published).record["scenario"], "record")
    assert load_scenario(file) == solved and file.stem == published.parent.name


@pytest.fixture
def inside(described: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv("HF_HOME", str(tmp_path))
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    monkeypatch.chdir(described)
    yield described


@pytest.mark.parametrize("library", ["pandas", "polars", "duckdb", "datasets", "gaitflow"])
def test_the_three_lines_of_the_card_load_it(inside: Path, library: str, capsys: pytest.CaptureFixture[str]) -> None:
    blocks = re.findall(r"```python\n(.*?)```", (inside / "README.md").read_text(), re.DOTALL)
    (block,) = [text for text in blocks if re.search(rf"(import|from) {library}\b", text)]
    assert len(block.splitlines()) == 3
    found: dict[str, object] = {}
    exec(block, found)
    if library == "datasets":
        assert found["labels"]["gait"][:] == pq.read_table("labels.parquet")["gait"].to_pylist()
    else:
        assert len(capsys.readouterr().out.splitlines()) >= 1


def test_what_is_published_stays_as_it_is(checkout: Path, tmp_path: Path) -> None:
    folder = checkout / "datasets" / DATASETS[0]
    with pytest.raises(ValueError, match="was published and never changes; choose another folder"):
        describe_dataset(folder, folder / "described")
    copy = tmp_path / "1.1.0"
    copy.mkdir()
    for path in folder.iterdir():
        (copy / path.name).write_bytes(path.read_bytes())
    damaged = json.loads((copy / "manifest.json").read_text())
    damaged["files"]["labels.parquet"]["sha256"] = "0" * 64
    (copy / "manifest.json").write_text(json.dumps(damaged))
    with pytest.raises(ArtifactError, match=r"labels.parquet: its content is not what the manifest lists"):
        describe_dataset(copy, tmp_path / "out")
    assert not (tmp_path / "out").exists()
