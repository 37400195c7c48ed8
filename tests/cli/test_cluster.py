from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner, Result

from gaitflow.cli import main
from gaitflow.execute.drivers import IN_DRIVER_JOB
from gaitflow.execute.schedulers.base import job_mark

PROFILE = "slurm/profiles/test-cluster.yaml"


@pytest.fixture
def project(tmp_path: Path, checkout: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A workspace with a profile, and Slurm commands that answer as told and write down what they were asked."""
    for name in ("configs", "slurm"):
        shutil.copytree(checkout / name, tmp_path / name)
    folder = tmp_path / "bin"
    folder.mkdir()
    (folder / "queue").touch()
    for name, text in {
        "sbatch": f"[ $1 = --test-only ] && cat > {folder}/tested.sh && exit; cat > {folder}/submitted.sh; echo 42",
        "squeue": f"cat {folder}/queue",
        "scancel": f'echo "$*" >> {folder}/cancelled',
    }.items():
        (folder / name).write_text(f"#!/bin/bash\n{text}\n")
        (folder / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}:/usr/bin:/bin")
    monkeypatch.delenv(IN_DRIVER_JOB, raising=False)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def gaitflow(*arguments: str) -> Result:
    return CliRunner().invoke(main, list(arguments))


def queue_of(project: Path) -> Path:
    run = project / "runs" / "quickstart"
    lines = [f"42|RUNNING|d|{job_mark(run, 'driver')}|None", f"43|PENDING|w|{job_mark(run, 'a-0')}|Priority"]
    lines.append(f"99|RUNNING|w|{job_mark(project / 'runs' / 'other', 'a-0')}|None")
    (project / "bin" / "queue").write_text("\n".join(lines) + "\n")
    return run


def test_submit_hands_the_driver_to_slurm(project: Path) -> None:
    done = gaitflow("submit", "quickstart", "--profile", PROFILE)
    assert done.exit_code == 0, done.output
    assert "driver job 42, up to 2 workers" in done.output and "gaitflow cancel quickstart" in done.output
    script = (project / "bin" / "submitted.sh").read_text()
    kept = project / "runs" / "quickstart" / "cluster" / "profile.yaml"
    assert f"solve quickstart --profile {kept}" in script
    assert kept.read_bytes() == (project / PROFILE).read_bytes()
    assert (project / "runs" / "quickstart" / "logs").is_dir(), "Slurm does not make it"


def test_workers_that_slurm_would_refuse_are_told_before_anything_is_submitted(project: Path) -> None:
    sbatch = project / "bin" / "sbatch"
    sbatch.write_text(f"#!/bin/bash\ncat > {project}/bin/last.sh\necho 'allocation failure: Invalid qos' >&2\nexit 1\n")
    done = gaitflow("submit", "quickstart", "--profile", PROFILE)
    assert done.exit_code == 1 and "sbatch: allocation failure: Invalid qos" in done.output
    assert "quickstart-worker" in (project / "bin" / "last.sh").read_text()
    assert not (project / "runs").exists()


def test_a_dry_run_prints_every_script_and_does_nothing(project: Path) -> None:
    done = gaitflow("submit", "quickstart", "--profile", PROFILE, "--dry-run")
    assert done.exit_code == 0
    assert done.output.count("#!/bin/bash") == 2
    assert "# driver: 1 job\n" in done.output and "# workers: 2 jobs, submitted by the driver\n" in done.output
    assert not (project / "runs").exists() and not (project / "bin" / "submitted.sh").exists()
    data = json.loads(gaitflow("submit", "quickstart", "--profile", PROFILE, "--dry-run", "--json").output)
    assert data["job"] is None and data["driver"] in done.output and data["worker"] in done.output
    gaitflow("submit", "quickstart", "--profile", PROFILE)
    assert (project / "bin" / "submitted.sh").read_text() == data["driver"], "what is printed is what is submitted"


def test_submit_says_what_is_left_or_how_to_find_out(project: Path) -> None:
    assert (
        "# CPU hours left: `gaitflow estimate quickstart` tells"
        in gaitflow("submit", "quickstart", "--profile", PROFILE, "--dry-run").output
    )
    done = gaitflow("submit", "quickstart", "--profile", PROFILE)
    assert "CPU hours left: `gaitflow estimate quickstart` tells" in done.output


def test_mail_at_the_end_is_a_directive_of_the_driver(project: Path) -> None:
    profile = yaml.safe_load((project / PROFILE).read_text())
    profile["driver"] = {"directives": ["--mail-type=END,FAIL"]}
    (project / "mail.yaml").write_text(yaml.safe_dump(profile))
    scripts = json.loads(gaitflow("submit", "quickstart", "--profile", "mail.yaml", "--dry-run", "--json").output)
    assert "#SBATCH --mail-type=END,FAIL\n" in scripts["driver"] and "--mail" not in scripts["worker"]


def test_a_second_submit_is_refused_with_the_way_out(project: Path) -> None:
    queue_of(project)
    done = gaitflow("submit", "quickstart", "--profile", PROFILE)
    assert done.exit_code == 1
    assert "driver job 42 is running" in done.output and "`gaitflow cancel quickstart`" in done.output
    assert not (project / "bin" / "submitted.sh").exists()


def test_solve_from_here_is_refused_while_a_driver_job_lives(project: Path) -> None:
    queue_of(project)
    done = gaitflow("solve", "quickstart", "--profile", PROFILE)
    assert done.exit_code == 1 and "driver job 42 is running" in done.output


def test_run_solves_with_the_profile_and_does_the_rest_here(
    project: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only the solve stage hears of the profile, through Snakemake; that it would be refused shows that it does."""
    queue_of(project)
    assert gaitflow("run", "quickstart", "--profile", PROFILE, "--dry-run").exit_code == 0
    monkeypatch.chdir(project.parent)
    profile = str((project / PROFILE).relative_to(project.parent))
    assert gaitflow("--root", project.name, "run", "quickstart", "--profile", profile).exit_code == 1
    assert "driver job 42 is running" in "".join(capfd.readouterr())
    assert "GAITFLOW_PROFILE" not in os.environ


@pytest.mark.parametrize(
    "command", [["submit", "quickstart"], ["doctor"], ["solve", "quickstart"], ["run", "quickstart"]]
)
def test_a_faulty_profile_is_bad_input(project: Path, command: list[str]) -> None:
    (project / "bad.yaml").write_text("name: bad\njobs: 0\nwalltime: soon\n")
    done = gaitflow(*command, "--profile", "bad.yaml")
    assert done.exit_code == 2
    assert "bad.yaml: jobs = 0" in done.output and "bad.yaml: walltime: 'soon'" in done.output
    done = gaitflow(*command, "--profile", "missing.yaml")
    assert done.exit_code == 2 and "missing.yaml: cannot be read" in done.output


def test_the_driver_gets_the_whole_path_of_a_scenario_s_file(project: Path) -> None:
    text = (project / "configs/scenarios/quickstart.yaml").read_text()
    (project / "mine.yaml").write_text(text.replace("name: quickstart", "name: mine"))
    done = gaitflow("submit", "mine.yaml", "--profile", PROFILE, "--dry-run")
    assert done.exit_code == 0
    assert f"solve {project / 'mine.yaml'} --profile {project / 'runs/mine/cluster/profile.yaml'}" in done.output


def test_a_profile_that_ships_is_found_by_name(project: Path) -> None:
    for name in ("configs", "slurm"):
        shutil.rmtree(project / name)
    done = gaitflow("submit", "quickstart", "--profile", "centre-48h", "--dry-run")
    assert done.exit_code == 0 and "#SBATCH --time=48:00:00" in done.output
    unknown = gaitflow("submit", "quickstart", "--profile", "centre-47h", "--dry-run")
    assert unknown.exit_code == 2 and "did you mean centre-48h?" in unknown.output


def test_cancel_ends_the_run_s_jobs_and_only_them(project: Path) -> None:
    queue_of(project)
    done = gaitflow("cancel", "quickstart")
    assert done.exit_code == 0 and "cancelled 42 d, which was running" in done.output
    assert (project / "bin" / "cancelled").read_text() == "--quiet 42 43\n"
    data = json.loads(gaitflow("cancel", "quickstart", "--json").output)
    assert [job["id"] for job in data["cancelled"]] == ["42", "43"]


def test_cancel_tells_of_a_process_that_would_submit_again(project: Path) -> None:
    run = queue_of(project)
    run.mkdir(parents=True, exist_ok=True)
    (run / "driver.json").write_text(json.dumps({"host": "login1", "pid": 7, "user": "anna", "started": 1}))
    assert "the process 7 of anna on login1 still drives this run" in gaitflow("cancel", "quickstart").output


def test_status_tells_jobs_and_logs_and_needs_no_slurm(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = queue_of(project)
    for name in ("cluster", "logs"):
        (run / name).mkdir(parents=True)
    done = gaitflow("status", "quickstart")
    assert "jobs: driver 1 running; workers 1 pending; waiting for Priority" in done.output
    assert f"logs: {Path('runs/quickstart/logs')}" in done.output
    data = json.loads(gaitflow("status", "quickstart", "--json").output)
    assert data["jobs"]["driver"] == {"RUNNING": 1} and data["jobs"]["waiting_for"] == {"Priority": 1}
    (run / "cluster" / "jobs.json").unlink()
    monkeypatch.setenv("PATH", "/nowhere")
    data = json.loads(gaitflow("status", "quickstart", "--json").output)
    assert data["jobs"] is None and data["left"] == data["units"]


@pytest.mark.parametrize("command", [["submit", "quickstart"], ["cancel", "quickstart"], ["doctor"]])
def test_without_slurm_the_way_out_is_told(project: Path, monkeypatch: pytest.MonkeyPatch, command: list[str]) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    done = gaitflow(*command, *(["--profile", PROFILE] if command[0] != "cancel" else []))
    assert done.exit_code == 1 and "not found; run this where Slurm is" in done.output
    assert "Traceback" not in done.output
