"""The command line as a user meets it: every stage on a small scenario, and one clear line for what cannot be used."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import yaml
from click.testing import CliRunner, Result

from gaitflow.cli import main
from gaitflow.cli.plan import PLAN_KEYS
from gaitflow.core.task import AXES
from gaitflow.pipeline import stages
from gaitflow.pipeline.workspace import Workspace
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import plan_units

REPO = Path(__file__).resolve().parents[2]


def small(**changes: Any) -> dict[str, Any]:
    """A scenario of 6 tasks with 3 knots a phase, which solves in seconds and has two gaits or more."""
    data = yaml.safe_load((REPO / "configs/scenarios/quickstart.yaml").read_text())
    data["name"] = "small"
    data["transcription"] = {"phases": 4, "knots_per_phase": 3}
    axes = {"speed": {"start": 0.3, "stop": 1.9, "count": 3}, "cycle_duration": {"start": 0.4, "stop": 0.8, "count": 2}}
    data["tasks"] = {"axes": axes}
    data["learning"] = {"folds": 2, "max_epochs": 30, "hidden_layers": [[10, 10, 10]], "learning_rates": [0.01]}
    return data | changes


def make_root(root: Path, **changes: Any) -> Path:
    shutil.copytree(REPO / "configs/robots", root / "configs/robots")
    (root / "configs/scenarios").mkdir()
    (root / "configs/scenarios/small.yaml").write_text(yaml.safe_dump(small(**changes)))
    return root


def call(root: Path, *arguments: str) -> Result:
    return CliRunner().invoke(main, ["--root", str(root), *arguments])


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A workspace in which the small scenario went through all stages."""
    root = make_root(tmp_path_factory.mktemp("workspace"))
    for command in ("solve", "label", "atlas", "train", "publish", "report"):
        done = call(root, command, "small")
        assert done.exit_code == 0, f"{command}: {done.output}"
        (root / f"{command}.txt").write_text(done.stdout)
    yield root


def test_the_stages_publish_a_map_that_answers_and_verifies(solved: Path) -> None:
    model, dataset = solved / "models/small/1.0.0", solved / "datasets/small/1.0.0"
    assert {path.name for path in (solved / "runs/small/report").iterdir()} >= {"index.html", "map.png"}
    for folder in (model, dataset):
        done = call(solved, "verify", str(folder), "--json")
        assert done.exit_code == 0 and json.loads(done.stdout) == {"path": str(folder), "sound": True, "faults": []}
    done = call(solved, "plan", str(model.parent), "--speed", "1.1", "--cycle", "0.6", "--json")
    plan = json.loads(done.stdout)
    assert done.exit_code == 0
    assert set(plan) == {"task", "chosen", *PLAN_KEYS} and plan["task"] == {"speed": 1.1, "cycle_duration": 0.6}
    assert plan["feasible"] and plan["violation"] <= 1e-6
    assert sum(plan["durations"]) == pytest.approx(0.6)
    assert plan["path"] == "fast" and plan["in_domain"] and 0 < plan["distance"] < 0.71
    assert 0 < plan["select_ms"] + plan["predict_ms"] + plan["refine_ms"] <= plan["time_ms"]
    assert plan["chosen"] is None


def test_a_plan_may_name_its_gait_and_leave_the_cycle_duration_to_the_map(solved: Path) -> None:
    model = solved / "models/small"
    done = call(solved, "plan", str(model), "--speed", "1.1", "--json")
    plan = json.loads(done.stdout)
    assert done.exit_code == 0 and plan["chosen"]["value"] == plan["task"]["cycle_duration"]
    assert plan["chosen"]["cost_per_metre"] == pytest.approx(plan["chosen"]["cost_per_second"] / 1.1)
    again = call(solved, "plan", str(model), "--speed", "1.1", "--cycle", "0.6", "--gait", plan["gait"], "--json")
    assert again.exit_code == 0 and json.loads(again.stdout)["gait"] == plan["gait"]
    unknown = call(solved, "plan", str(model), "--speed", "1.1", "--cycle", "0.6", "--gait", "moonwalk")
    assert unknown.exit_code == 2 and "gait = 'moonwalk': the map has" in unknown.stderr


def test_the_atlas_tells_its_nodes_and_how_the_predictors_did(solved: Path) -> None:
    before = (solved / "runs/small/learning/atlas.safetensors").read_bytes()
    done = call(solved, "atlas", "small", "--json")
    data = json.loads(done.stdout)
    assert done.exit_code == 0
    assert (solved / "runs/small/learning/atlas.safetensors").read_bytes() == before, "equal datasets, equal atlases"
    assert set(data) == {"gaits", "nodes", "solves", "modes", "bytes", "predictions", "missed_labels"}
    assert data["bytes"] == len(before) and sum(data["nodes"].values()) > 6
    judged = data["predictions"]
    assert 0 < judged["converged"] <= judged["tasks"]
    text = (solved / "atlas.txt").read_text()
    for pattern, nodes in data["nodes"].items():
        assert f"{nodes:6d} nodes  {pattern}\n" in text
    assert f"{judged['converged']} of {judged['tasks']} predictions" in text
    assert f"{data['solves']} solves, {data['modes']} modes" in text


def test_an_estimate_solves_a_part_and_says_what_is_left(tmp_path: Path) -> None:
    make_root(tmp_path)
    state = json.loads(call(tmp_path, "estimate", "small", "--units", "1", "--workers", "1", "--json").stdout)
    assert (state["units"], state["solved"], state["left"]) == (2, 1, 1)
    assert state["cpu_hours_left"] == pytest.approx(state["cpu_hours_spent"]) and state["cpu_hours_left"] > 0
    again = call(tmp_path, "estimate", "small", "--units", "1")
    assert again.exit_code == 0 and "small: 1 of 2 units solved" in again.stdout, "nothing is solved twice"
    assert f"{state['cpu_hours_left']:.3g}" in again.stdout


def test_labels_are_printed_as_published(solved: Path) -> None:
    rows = json.loads(call(solved, "labels", str(solved / "datasets/small/1.0.0"), "--json").stdout)
    assert len(rows) == 6
    told = {
        "speed",
        "cycle_duration",
        "gait",
        "pattern",
        "cost",
        "margin",
        "runner_up",
        "status",
        "cost_error",
        "resolved",
    }
    assert told <= set(rows[0])
    assert all(row["status"] == "solved" and isinstance(row["resolved"], bool) for row in rows)
    lines = call(solved, "labels", str(solved / "datasets/small/1.0.0")).stdout.splitlines()
    assert len(lines) == 6 and lines[0].startswith(" 0.300 m/s   0.400 s  ")


def test_older_labels_are_printed_and_other_files_refused(checkout: Path, tmp_path: Path) -> None:
    rows = json.loads(
        call(tmp_path, "labels", str(checkout / "datasets/half-cheetah-flat-effort/1.0.0"), "--json").stdout
    )
    assert len(rows) == 124 and rows[0]["resolved"] is None and rows[0]["cost_error"] is None
    pd.DataFrame({"speed": [1.0]}).to_parquet(tmp_path / "odd.parquet")
    (tmp_path / "text.parquet").write_text("text")
    for name, says in (("odd", "column cycle_duration is missing"), ("text", "not a readable Parquet file")):
        done = call(tmp_path, "labels", str(tmp_path / f"{name}.parquet"))
        assert done.exit_code == 2 and says in done.stderr and len(done.stderr.splitlines()) == 1


def test_status_counts_what_is_stored_and_needs_no_run(solved: Path, tmp_path: Path) -> None:
    after = json.loads(call(solved, "status", "small", "--json").stdout)
    assert (after["units"], after["solved"], after["left"]) == (2, 2, 0)
    assert after["cpu_hours_spent"] > 0
    before = json.loads(call(make_root(tmp_path), "status", "small", "--json").stdout)
    assert (before["units"], before["solved"], before["left"]) == (2, 0, 2)


def test_solving_again_solves_nothing(solved: Path) -> None:
    def starts() -> int:
        lines = "".join(path.read_text() for path in (solved / "runs/small/journal").glob("*.jsonl"))
        return lines.count('"start"')

    before = starts()
    assert call(solved, "solve", "small").exit_code == 0
    assert starts() == before > 0


def test_publishing_the_same_again_makes_no_version(solved: Path) -> None:
    assert call(solved, "publish", "small").exit_code == 0
    assert [path.name for path in (solved / "models/small").iterdir()] == ["1.0.0"]
    done = call(solved, "publish", "small", "--version", "1.0.0")
    assert done.exit_code == 1 and "published already" in done.stderr


def test_a_map_beyond_its_limits_is_published_only_by_force(solved: Path, tmp_path: Path) -> None:
    root = tmp_path / "copy"
    shutil.copytree(solved, root)
    (root / "docs/results").mkdir(parents=True)
    certificate = root / "docs/results/certificate-small.json"

    def certify(problem: str) -> None:
        certificate.write_text(json.dumps({"scenario": "small", "summary": {"problem": problem, "gap_max_rel": 0.3}}))

    certify("of another robot")
    disregarded = call(root, "publish", "small")
    assert disregarded.exit_code == 0 and len(disregarded.stderr.splitlines()) == 1
    assert "does not count" in disregarded.stderr and "`gaitflow bench certificate small`" in disregarded.stderr
    certify(Workspace(root).scenario("small").problem_digest)
    refused = call(root, "publish", "small")
    assert refused.exit_code == 1 and "is 0.3, more than limits.certificate_gap = 0.01" in refused.stderr
    assert len(refused.stderr.splitlines()) == 1
    assert [each.name for each in (root / "models/small").iterdir()] == ["1.0.0"]
    forced = json.loads(call(root, "publish", "small", "--force", "--json").stdout)
    card = Path(forced["model"], "README.md").read_text()
    assert forced["version"] == "1.1.0" and "- share by which a label costs more than what its certificate" in card
    assert call(root, "verify", forced["model"]).exit_code == 0


def test_a_damaged_dataset_is_found(solved: Path, tmp_path: Path) -> None:
    copy = tmp_path / "1.0.0"
    shutil.copytree(solved / "datasets/small/1.0.0", copy)
    for name in ("solutions.parquet", "labels.parquet", "gait_costs.parquet", "README.md"):
        content = bytearray((copy / name).read_bytes())
        content[len(content) // 3] ^= 4
        (copy / name).write_bytes(content)
        done = call(solved, "verify", str(copy))
        assert done.exit_code == 1 and f"{name}: its content is not what the manifest lists" in done.stdout
        content[len(content) // 3] ^= 4
        (copy / name).write_bytes(content)
    assert call(solved, "verify", str(copy)).exit_code == 0


def test_out_of_domain_fails_and_nan_is_bad_input(solved: Path) -> None:
    model = str(solved / "models/small")
    far = call(solved, "plan", model, "--speed", "9", "--cycle", "0.6", "--json")
    assert far.exit_code == 1
    refused = json.loads(far.stdout)
    assert refused["in_domain"] is False and refused["feasible"] is False and refused["gait"] is None
    assert set(refused) == {"task", "chosen", *PLAN_KEYS}
    assert "speed = 9 m/s is outside" in far.stderr
    beyond = call(solved, "plan", model, "--speed", "2.0", "--cycle", "0.6", "--beyond")
    assert "outside the map's domain, " in beyond.stdout and "feasible:    " in beyond.stdout
    beyond = json.loads(call(solved, "plan", model, "--speed", "2.0", "--cycle", "0.6", "--beyond", "--json").stdout)
    assert beyond["in_domain"] is False and beyond["distance"] > 0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--speed", "nan", "--cycle", "0.6"], "speed = nan: must be a finite number"),
        ([], "needs speed, cycle_duration as well; the axes are speed, cycle_duration"),
        (
            ["--speed", "1.1", "--cycle", "0.6", "--slope", "-8"],
            "slope = -8: it is fixed at 0 deg here; the axes are speed",
        ),
        (
            ["--speed", "1.1", "--cycle", "0.6", "--speed", "1.2"],
            "--speed is given 2 times: 1.1 and 1.2; a task has one",
        ),
        (["--speed", "1.1", "--cycle", "0.6", "--cycle-duration", "0.7"], "--cycle is given 2 times: 0.6 and 0.7"),
    ],
    ids=["nan", "missing", "lacking", "twice", "twice by two names"],
)
def test_a_task_that_is_none_of_the_maps_is_one_clear_line(solved: Path, arguments: list[str], says: str) -> None:
    done = call(solved, "plan", str(solved / "models/small"), *arguments)
    assert done.exit_code == 2 and says in done.stderr
    assert len(done.stderr.splitlines()) == 1 and not done.stdout


def test_an_axis_that_a_map_holds_may_be_given_with_its_value(solved: Path) -> None:
    task = ["--speed", "1.1", "--cycle", "0.6", "--friction", "0.8", "--slope", "0"]
    done = call(solved, "plan", str(solved / "models/small"), *task)
    assert done.exit_code == 0 and "task:        speed 1.1 m/s, cycle_duration 0.6 s" in done.stdout


def test_code_in_an_older_map_is_run_only_when_told(checkout: Path, tmp_path: Path) -> None:
    arguments = ["plan", str(checkout / "models/half-cheetah-flat-effort/1.1.0"), "--speed", "0.9", "--cycle", "0.6"]
    refused = call(tmp_path, *arguments)
    assert refused.exit_code == 2 and "--trust-code" in refused.stderr and len(refused.stderr.splitlines()) == 1
    assert call(tmp_path, *arguments, "--trust-code").exit_code == 0


def test_every_axis_of_the_register_is_an_option() -> None:
    told = CliRunner().invoke(main, ["plan", "--help"]).stdout
    assert all(f"--{axis.replace('_', '-')}" in told for axis in AXES)


def test_a_foreign_part_is_quarantined_named_and_solved_again(solved: Path, tmp_path: Path) -> None:
    root = tmp_path / "copy"
    shutil.copytree(solved, root)
    parts = sorted((root / "runs/small/units").rglob("*.parquet"))
    parts[0].write_bytes(b"PAR1 something else PAR1")
    done = call(root, "solve", "small")
    assert done.exit_code == 0, done.output
    assert parts[0].name.removesuffix(".parquet")[:12] in done.stderr
    assert list((root / "runs/small/quarantine").glob("*.parquet"))
    old, new = (pd.read_parquet(each / "runs/small/solutions.parquet", columns=["cost"]) for each in (solved, root))
    pd.testing.assert_frame_equal(old, new)


@pytest.mark.parametrize(
    ("changes", "field", "words"),
    [
        ({"robot": "no_such_robot"}, "robot", "half_cheetah"),
        ({"stances_per_leg": 2}, "stances_per_leg", "1"),
        ({"colour": "red"}, "colour", "unknown field"),
        ({"transcription": {"phases": 4, "min_phase_fraction": 0.3}}, "transcription", "do not fit"),
        ({"strategy": {"name": "fixed_gait", "pattern": "01x0/1100"}}, "pattern", "01x0/1100"),
        ({"objective": {"force": -1.0}}, "objective.force", "-1"),
    ],
)
def test_a_bad_scenario_is_one_clear_line_and_exit_2(
    tmp_path: Path, changes: dict[str, Any], field: str, words: str
) -> None:
    root = make_root(tmp_path, **changes)
    for command in ("validate", "solve", "status", "label", "atlas", "train", "publish", "report", "run"):
        done = call(root, command, "small")
        assert done.exit_code == 2
        assert "small.yaml" in done.stderr and field in done.stderr and words in done.stderr
        assert "Traceback" not in done.output


def test_a_robot_of_negative_mass_is_refused_by_name(tmp_path: Path) -> None:
    root = make_root(tmp_path)
    robot = root / "configs/robots/half_cheetah.yaml"
    robot.write_text(robot.read_text().replace("mass: 14.0", "mass: -14.0"))
    done = call(root, "validate", "small")
    assert done.exit_code == 2
    assert all(part in done.stderr for part in ("half_cheetah.yaml", "mass", "-14", "greater than 0"))


def test_validate_foretells_solves_and_cpu_hours(tmp_path: Path) -> None:
    root = make_root(tmp_path)
    said, data = call(root, "validate", "small"), json.loads(call(root, "validate", "small", "--json").stdout)
    assert f"about {data['solves']}" in said.stdout and "`gaitflow estimate small` measures them" in said.stdout
    assert data["tasks"] <= data["solves"] <= 2 * data["tasks"] * data["patterns"]
    assert 0 < data["cpu_hours"] < 1


def test_an_unknown_scenario_lists_those_there_are(tmp_path: Path) -> None:
    done = call(make_root(tmp_path), "solve", "smal")
    assert done.exit_code == 2 and "'smal'" in done.stderr and "did you mean small?" in done.stderr


def test_a_missing_stage_names_the_command(tmp_path: Path) -> None:
    root = make_root(tmp_path)
    before_each = {"label": "solve", "atlas": "label", "train": "label", "publish": "train", "report": "label"}
    for command, before in before_each.items():
        done = call(root, command, "small")
        assert done.exit_code == 1 and f"gaitflow {before} small" in done.stderr


def test_tasks_without_any_gait_cannot_be_learnt(tmp_path: Path) -> None:
    root = make_root(tmp_path, tasks={"axes": {
        "speed": {"start": 19.0, "stop": 20.0, "count": 2},
        "cycle_duration": {"start": 0.4, "stop": 0.5, "count": 2},
    }})  # fmt: skip
    assert call(root, "solve", "small").exit_code == 0
    label = call(root, "label", "small")
    assert label.exit_code == 0 and "4  infeasible" in label.stdout
    atlas = call(root, "atlas", "small", "--json")
    assert atlas.exit_code == 0 and json.loads(atlas.stdout)["nodes"] == {}
    done = call(root, "train", "small", "--constant")
    assert done.exit_code == 1 and "none of the 4 tasks" in done.stderr


def test_one_gait_everywhere_is_published_only_when_asked_for(tmp_path: Path) -> None:
    strategy = {"name": "fixed_gait", "pattern": "0011/0110", "restarts": 1}
    root = make_root(tmp_path, strategy=strategy)
    assert call(root, "solve", "small").exit_code == 0
    assert call(root, "label", "small").exit_code == 0
    assert call(root, "atlas", "small").exit_code == 0
    refused = call(root, "train", "small")
    assert refused.exit_code == 1 and "--constant" in refused.stderr and "'gallop'" in refused.stderr
    assert call(root, "train", "small", "--constant").exit_code == 0
    published = call(root, "publish", "small")
    assert published.exit_code == 0, published.output
    plan = call(root, "plan", str(root / "models/small"), "--speed", "1.1", "--cycle", "0.6", "--json")
    assert json.loads(plan.stdout)["gait"] == "gallop"


def test_a_full_disk_loses_nothing_and_says_the_way_out(
    solved: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    root = tmp_path / "copy"
    shutil.copytree(solved, root)
    before = (root / "runs/small/labels.parquet").read_bytes()

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("gaitflow.files.os.fsync", full)
    done = call(root, "label", "small")
    assert done.exit_code == 1 and "free some space" in done.stderr
    assert (root / "runs/small/labels.parquet").read_bytes() == before
    assert not list((root / "runs/small").glob("*.tmp"))


def test_claims_without_published_datasets_are_not_measured(tmp_path: Path) -> None:
    done = call(make_root(tmp_path), "report", "--claims", "--json")
    assert done.exit_code == 0
    assert {row[key] for row in json.loads(done.stdout) for key in ("verdict", "exact_verdict")} == {"not measured"}


def test_maps_stand_side_by_side_when_both_are_published(checkout: Path, tmp_path: Path) -> None:
    missing = call(tmp_path, "report", "--exact-motion")
    assert missing.exit_code == 2 and "publish one of each first" in missing.stderr
    for name in ("half-cheetah-flat-effort", "half-cheetah-exact-effort"):
        shutil.copytree(checkout / "datasets/half-cheetah-flat-effort/1.0.0", tmp_path / "datasets" / name / "1.0.0")
    done = call(tmp_path, "report", "--exact-motion")
    assert done.exit_code == 0, done.output
    files = ["images/exact-half-cheetah-flat-effort.png", "results/exact-motion.md"]
    assert done.stdout.splitlines() == [str(tmp_path / "docs" / name) for name in files]


def test_report_wants_a_scenario_or_claims(tmp_path: Path) -> None:
    root = make_root(tmp_path)
    assert call(root, "report").exit_code == 2
    assert call(root, "report", "small", "--claims").exit_code == 2
    assert call(root, "report", "--exact-motion", "--claims").exit_code == 2


def test_every_command_explains_itself_with_an_example() -> None:
    assert set(main.commands) == {
        "atlas", "bench", "cancel", "certify", "compact", "datasets", "doctor", "drive", "estimate", "export", "init",
        "label", "labels", "models", "paper", "plan", "publish", "report", "robot", "run", "show", "solve", "status",
        "submit", "sweep", "trace", "train", "upload", "validate", "verify", "walk",
    }  # fmt: skip
    for name in main.commands:
        done = CliRunner().invoke(main, [name, "--help"])
        assert done.exit_code == 0 and "Example: gaitflow" in done.stdout


def test_the_workflow_calls_only_commands_that_there_are() -> None:
    rules = "".join(path.read_text() for path in (REPO / "workflow/rules").glob("*.smk"))
    called = {line.split()[1] for line in rules.replace('"', " ").splitlines() if line.strip().startswith("gaitflow ")}
    assert called == {"solve", "label", "atlas", "train", "publish", "report"}
    assert called <= set(main.commands)


def test_the_store_of_a_run_holds_every_planned_unit(solved: Path) -> None:
    workspace = Workspace(solved)
    scenario = workspace.scenario("small")
    store = UnitStore(workspace.run(scenario).folder)
    assert store.solved() == {unit.digest for unit in plan_units(scenario)}
    assert stages.summary(scenario)["units"] == 2
