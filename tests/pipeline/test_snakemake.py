"""The stage graph: which rules a changed scenario reruns, and that a rule is one `gaitflow` command."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path

import pytest
from click.testing import CliRunner

from gaitflow.cli import main

STAGES = ("solve", "label", "atlas", "train", "publish", "report")
# In the order the stages write them.
RESULTS = (
    "solutions.parquet",
    "labels.parquet",
    "gait_costs.parquet",
    "learning/atlas.safetensors",
    "learning/atlas.json",
    "learning/learning.json",
    "learning/classifier.onnx",
    "published.json",
    "report/index.html",
)


def _copy_of_the_graph(checkout: Path, folder: Path) -> Path:
    for part in ("workflow", "configs"):
        shutil.copytree(checkout / part, folder / part)
    return folder


@pytest.fixture
def workspace(checkout: Path, tmp_path: Path) -> Path:
    """A copy of the workflow and the configurations, without results."""
    return _copy_of_the_graph(checkout, tmp_path)


@pytest.fixture(scope="module")
def finished_run(checkout: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The workspace after a complete run: the stamps that planning writes, then a result of every stage."""
    folder = _copy_of_the_graph(checkout, tmp_path_factory.mktemp("finished"))
    planned(folder)
    for name in RESULTS:
        file = folder / "runs" / "quickstart" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(name)
    return folder


@pytest.fixture
def finished(finished_run: Path, tmp_path: Path) -> Path:
    """A copy of the finished run to change; copying keeps the times of files."""
    return shutil.copytree(finished_run, tmp_path / "run")


def snakemake(workspace: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "snakemake", "--cores", "1", *arguments]
    return subprocess.run(command, cwd=workspace, capture_output=True, text=True, timeout=60, check=False)


def planned(workspace: Path, *arguments: str) -> list[str]:
    """Stages that a dry run would run, in the order of the flow."""
    dry = snakemake(workspace, "--dry-run", *arguments)
    assert dry.returncode == 0, dry.stderr
    rules = set(re.findall(r"^rule (\w+):$", dry.stdout + dry.stderr, flags=re.MULTILINE))
    return [stage for stage in STAGES if stage in rules]


def shell_commands(workspace: Path, *arguments: str) -> list[str]:
    """The commands that a dry run would give."""
    printed = snakemake(workspace, "--dry-run", "--printshellcmds", *arguments)
    # rules without a command print "None"
    return re.findall(r"^Shell command: (?!None$)(.*)$", printed.stdout + printed.stderr, flags=re.MULTILINE)


def edit(file: Path, old: str, new: str) -> None:
    text = file.read_text(encoding="utf-8")
    assert text.count(old) == 1, f"{file.name} does not hold {old!r} once"
    time.sleep(0.02)  # a change is newer than the results by more than the clock's resolution
    file.write_text(text.replace(old, new), encoding="utf-8")


def test_each_stage_is_one_gaitflow_command(workspace: Path) -> None:
    commands = [command.partition(" --workers ")[0] for command in shell_commands(workspace)]
    assert sorted(commands) == sorted(f"gaitflow {stage} quickstart" for stage in STAGES)


@pytest.mark.parametrize("cores", ["1", "5"])
def test_solve_has_as_many_workers_as_there_are_cores(workspace: Path, cores: str) -> None:
    (solve,) = (one for one in shell_commands(workspace, "--cores", cores) if one.startswith("gaitflow solve"))
    assert solve == f"gaitflow solve quickstart --workers {cores}"


def test_targets_stop_at_their_stage(workspace: Path) -> None:
    assert planned(workspace, "--", "datasets") == ["solve", "label"]
    assert planned(workspace, "--", "models") == ["solve", "label", "atlas", "train", "publish"]


def test_finished_run_is_left_alone_when_files_are_only_touched(finished: Path) -> None:
    scenario = finished / "configs" / "scenarios" / "quickstart.yaml"
    edit(scenario, "name: quickstart\n", "name: quickstart  # a comment changes nothing\n")
    (finished / "configs" / "robots" / "half_cheetah.yaml").touch()
    assert planned(finished) == []


def test_learning_settings_rerun_training_and_what_follows(finished: Path) -> None:
    edit(finished / "configs" / "scenarios" / "quickstart.yaml", "folds: 3", "folds: 4")
    assert planned(finished) == ["train", "publish", "report"]


def test_tie_tolerance_reruns_labels_too(finished: Path) -> None:
    edit(finished / "configs" / "scenarios" / "quickstart.yaml", "learning: {", "learning: {tie_tolerance: 0.01, ")
    assert planned(finished) == ["label", "atlas", "train", "publish", "report"]


def test_changed_robot_reruns_everything(finished: Path) -> None:
    edit(finished / "configs" / "robots" / "half_cheetah.yaml", "mass: 14.0", "mass: 15.0")
    assert planned(finished) == list(STAGES)


def test_what_a_stage_made_by_its_own_command_is_up_to_date(workspace: Path) -> None:
    scenario = workspace / "configs" / "scenarios" / "quickstart.yaml"
    for old, new in (("count: 6", "count: 2"), ("count: 4", "count: 2"), ("held_out: 6", "held_out: 0")):
        edit(scenario, old, new)
    made = CliRunner().invoke(main, ["--root", str(workspace), "solve", "quickstart", "--workers", "1"])
    assert made.exit_code == 0, made.output
    assert planned(workspace) == ["label", "atlas", "train", "publish", "report"]


def test_bad_scenario_stops_before_anything_runs(finished: Path) -> None:
    edit(finished / "configs" / "robots" / "half_cheetah.yaml", "mass: 14.0", "mass: -14.0")
    refused = snakemake(finished, "--dry-run")
    assert refused.returncode == 1
    assert "half_cheetah.yaml: mass = -14.0" in refused.stdout + refused.stderr


def test_stages_form_one_chain(workspace: Path) -> None:
    drawn = snakemake(workspace, "--dag")
    assert drawn.returncode == 0, drawn.stderr
    graph = drawn.stdout
    names = dict(re.findall(r'(\d+)\[label = "(\w+)', graph))
    edges = {(names[a], names[b]) for a, b in re.findall(r"(\d+) -> (\d+)", graph)}
    assert set(pairwise(STAGES)) <= edges
    assert all(STAGES.index(a) < STAGES.index(b) for a, b in edges if b != "all")


@pytest.mark.parametrize("given", ["quickstart", "elsewhere/mine.yaml"])
def test_run_needs_no_file_of_the_workspace(
    given: str, checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "elsewhere").mkdir()
    text = (checkout / "configs/scenarios/quickstart.yaml").read_text(encoding="utf-8")
    (tmp_path / "elsewhere" / "mine.yaml").write_text(text.replace("name: quickstart", "name: mine"), encoding="utf-8")
    (tmp_path / "workspace").mkdir()
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(main, ["--root", "workspace", "run", given, "--dry-run"])
    assert done.exit_code == 0, capfd.readouterr().err
    (folder,) = (tmp_path / "workspace" / "runs").iterdir()
    assert folder.name == Path(given).stem and (folder / "stamps" / "problem.json").is_file()
