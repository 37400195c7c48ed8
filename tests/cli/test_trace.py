"""`gaitflow trace` on published maps, and where the dataset of a map is found."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pandas as pd
import pytest
from click.testing import CliRunner, Result

from gaitflow.cli import main
from gaitflow.dataset import load_solutions
from gaitflow.runtime import GaitMap

TASK = ("--speed", "0.9", "--cycle", "0.6")
NAME = "half-cheetah-exact-vibration"


def trace(root: Path, *arguments: object) -> Result:
    return CliRunner().invoke(main, ["--root", str(root), "trace", *map(str, arguments)])


def test_an_answer_leads_to_the_solves_between_which_its_label_decided(checkout: Path) -> None:
    model = checkout / "models" / NAME
    done = trace(checkout, model, *TASK, "--json")
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert found["answer"]["gait"] == GaitMap.load(model).select(0.9, 0.6).gait == found["answer"]["known"][0]["gait"]
    assert found["dataset"]["folder"] == str(checkout / "datasets" / NAME / found["dataset"]["version"])
    decision, labels = found["decision"], pd.read_parquet(Path(found["dataset"]["folder"]) / "labels.parquet")
    label = labels[
        (labels["speed"] == decision["task"]["speed"])
        & (labels["cycle_duration"] == decision["task"]["cycle_duration"])
        & (labels["split"] == "grid")
    ].iloc[0]
    assert decision["margin"] == pytest.approx(label["margin"])
    assert (decision["solves"][0]["gait"], decision["solves"][0]["pattern"]) == (label["gait"], label["pattern"])
    assert {row["gait"] for row in decision["solves"]} == {label["gait"], label["runner_up"]}
    solutions = load_solutions(found["dataset"]["folder"])
    assert sum(decision["statuses"].values()) == len(solutions) // len(labels)
    assert all(maker in solutions.record["made_by"] for maker in found["solved_by"])
    told = trace(checkout, model, *TASK).stdout
    assert all(maker["code"]["commit"] in told and maker["cpu"] in told for maker in found["solved_by"])


def test_a_map_alone_says_what_it_was_learnt_from(checkout: Path, tmp_path: Path) -> None:
    version = next((checkout / "models" / NAME).iterdir())
    alone = shutil.copytree(version, tmp_path / "models" / NAME / version.name)
    done = trace(tmp_path, alone, *TASK)
    assert done.exit_code == 0 and f"{NAME} {version.name}, which is not here" in done.stdout
    assert "nearest node" in done.stdout and "solved by" not in done.stdout
    shutil.copytree(checkout / "datasets" / NAME / version.name, tmp_path / "datasets" / NAME / version.name)
    assert "solved by: gaitflow" in trace(checkout.parent, alone).stdout, "found beside the map, not in the root"


def test_a_map_of_an_older_format_finds_its_dataset_by_digest(checkout: Path) -> None:
    done = trace(checkout, checkout / "models/half-cheetah-flat-effort/1.1.0", "--json")
    assert done.exit_code == 0, done.output
    folder = json.loads(done.stdout)["dataset"]["folder"]
    assert folder == str(checkout / "datasets/half-cheetah-flat-effort/1.0.0")


def test_outside_the_domain_there_is_no_answer(checkout: Path) -> None:
    done = trace(checkout, checkout / "models" / NAME, "--speed", "9", "--cycle", "0.6")
    assert done.exit_code == 0 and "answer:    none: the task lies outside the map's domain" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("models/nowhere",), "no map here"),
        ((f"datasets/{NAME}",), "is a dataset, not a map"),
        ((f"models/{NAME}", "--speed", "0.9", "--payload", "3"), "payload = 3: it is fixed at 0 kg here"),
    ],
)
def test_what_cannot_be_traced_is_one_line(checkout: Path, arguments: tuple[str, ...], says: str) -> None:
    done = trace(checkout, checkout / arguments[0], *arguments[1:])
    assert done.exit_code == 2 and says in done.stderr and len(done.stderr.splitlines()) == 1
