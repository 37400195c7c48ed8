"""PBS: its scripts to the letter (tests/data/qsub), its answers, and runs with a stand-in for its commands."""

from __future__ import annotations

import getpass
import json
import os
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import stand_in_pbs
from click.testing import CliRunner, Result

from gaitflow.cli import main
from gaitflow.config.cluster import Profile, load_profile
from gaitflow.execute.doctor import examine
from gaitflow.execute.drivers import IN_DRIVER_JOB
from gaitflow.execute.run import run_units
from gaitflow.execute.schedulers import jobs, pool
from gaitflow.execute.schedulers.base import SchedulerError, job_mark
from gaitflow.execute.schedulers.cluster_client import cluster_client
from gaitflow.execute.schedulers.pbs import Pbs, parse_jobs, parse_records
from gaitflow.execute.schedulers.scripts import RESTARTS, doctor_script, driver_script, worker_script
from gaitflow.store.journal import read_journal
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit

CHECKOUT = Path(__file__).parents[3]
EXPECTED = CHECKOUT / "tests" / "data" / "qsub"
SHIPPED = CHECKOUT / "slurm" / "profiles" / "pbs-centre-48h.yaml"
RUN = Path("/shared/project/runs/quickstart")
PYTHON = "/shared/project/.venv/bin/python"
LEAST = {"name": "a", "scheduler": "pbs", "walltime": "01:00:00", "jobs": 2, "interface": "lo"}
PBS = Pbs()


def worker(profile: Profile, run: Path = RUN) -> str:
    return worker_script(PBS, profile, run, "4f1c2a-7", "tls://10.0.0.5:40001", 600.0, PYTHON)


def driver(profile: Profile, run: Path = RUN) -> str:
    kept = run / "cluster" / "profile.yaml", run / "cluster" / "driver.sh"
    return driver_script(PBS, profile, run, run.parents[1], "quickstart", *kept, PYTHON)


def doctor(profile: Profile, run: Path = RUN) -> str:
    return doctor_script(PBS, profile, run.parent / ".doctor-1", PYTHON)


JOBS: dict[str, Callable[[Profile], str]] = {"worker": worker, "driver": driver, "doctor": doctor}


@pytest.mark.parametrize("job", JOBS)
def test_the_text_of_each_job(job: str) -> None:
    text = JOBS[job](load_profile(SHIPPED))
    assert text == (EXPECTED / f"{SHIPPED.stem}.{job}.sh").read_text()
    subprocess.run(["bash", "-n"], input=text, text=True, check=True)
    assert len(list(EXPECTED.iterdir())) == len(JOBS)


def test_days_are_hours_and_what_the_profile_leaves_out_is_left_out() -> None:
    text = driver(Profile.from_data({"name": "a", "scheduler": "pbs", "walltime": "01:00:00", "jobs": 1}, "a"))
    assert "#PBS -l walltime=48:00:00\n" in text and "sleep 172740 &" in text
    assert "#PBS -q" not in text and "#PBS -A" not in text


@pytest.mark.parametrize("folder", ["/shared/it is", "/shared/a,b", "/shared/a\n#PBS -A root", "/shared/$(reboot)"])
def test_a_folder_that_pbs_could_misread_is_refused(folder: str) -> None:
    for make in (worker, driver, doctor):
        with pytest.raises(ValueError, match="move the project"):
            make(Profile.from_data(LEAST, "a"), Path(folder) / "runs" / "a")


LISTING = """\
Job Id: 11.pbs.example.org
    Job_Name = gaitflow-quickstart-driver
    job_state = R
    Variable_List = PBS_O_HOME=/users/anna,PBS_O_PATH=/usr/bin:/bin,GAITFLOW_JOB=gai
	tflow:{tag}:driver,GAITFLOW_RESTARTS=1
    comment = Job run at Mon Jan 05 at 10:00 on (n1:ncpus=1)

Job Id: 12.pbs.example.org
    Job_Name = gaitflow-quickstart-worker
    job_state = Q
    Variable_List = GAITFLOW_JOB=gaitflow:{tag}:ab-0,PBS_O_HOST=login1
    comment = Not Running: Insufficient amount of resource: ncpus

Job Id: 13.pbs.example.org
    job_state = E
    Variable_List = GAITFLOW_JOB=gaitflow:{tag}:ab-1

Job Id: 14.pbs.example.org
    job_state = H
    Variable_List = GAITFLOW_JOB=gaitflow:{tag}:ab-2

Job Id: 15.pbs.example.org
    job_state = R
    Variable_List = GAITFLOW_JOB=gaitflow:0123456789abcdef:ab-3

Job Id: 16.pbs.example.org
    job_state = R
    Variable_List = PBS_O_HOME=/users/anna
"""


def test_only_jobs_with_the_run_s_mark_are_its_jobs(tmp_path: Path) -> None:
    mark = job_mark(tmp_path, "")
    found = parse_jobs(LISTING.replace("{tag}", mark.split(":")[1]), mark)
    assert [(job.id, job.role, job.state, job.alive) for job in found] == [
        ("11", "driver", "RUNNING", True),
        ("12", "ab-0", "PENDING", True),
        ("13", "ab-1", "COMPLETING", False),
        ("14", "ab-2", "PENDING", True),
    ]
    assert found[1].reason == "Not Running: Insufficient amount of resource: ncpus" and "qrls" in found[3].reason


def test_a_cut_listing_is_read_as_far_as_it_goes() -> None:
    (record,) = parse_records("some warning\nJob Id: 11.pbs\n    job_state = R\n    Variable_Li")
    assert record.attributes == {"job_state": "R"}


@pytest.fixture
def pbs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The stand-in at work; at the end nothing of it runs."""
    folder = tmp_path / "pbs"
    monkeypatch.setenv("PATH", f"{stand_in_pbs.install(folder)}:/usr/bin:/bin")
    monkeypatch.delenv(IN_DRIVER_JOB, raising=False)
    monkeypatch.setattr(jobs, "ASK_EVERY_S", 0.5)
    return folder


def states(folder: Path) -> list[str]:
    return [job["state"] for job in stand_in_pbs.jobs(folder).values()]


def wait_until(condition: Callable[[], object], seconds: float = 60.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "it took too long"
        time.sleep(0.05)


def test_a_job_is_submitted_listed_and_ended(pbs: Path, tmp_path: Path) -> None:
    (tmp_path / "logs").mkdir()
    (pbs / "hold").touch()
    profile = Profile.from_data(LEAST, "a")
    assert PBS.submit(worker(profile, tmp_path)) == "1"
    (job,) = PBS.jobs(job_mark(tmp_path, ""))
    assert (job.id, job.role, job.state, job.reason) == (
        "1", "4f1c2a-7", "PENDING", "Not Running: Not enough free nodes"
    )  # fmt: skip
    assert PBS.jobs(job_mark(tmp_path / "other", "")) == ()
    PBS.cancel(["1", "99"])
    PBS.cancel(["1"])  # it has ended, which is no error
    assert PBS.jobs(job_mark(tmp_path, "")) == ()
    assert f"qselect -u {getpass.getuser()}\n" in (pbs / "calls").read_text()


def test_what_qsub_says_is_passed_on(pbs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (pbs / "refuse").write_text("Unauthorized Request")
    with pytest.raises(SchedulerError, match=r"^qsub: Unauthorized Request$"):
        PBS.submit("#!/bin/bash\n")
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(SchedulerError, match="qselect: not found; run this where PBS is"):
        PBS.jobs("gaitflow:")


def test_queues(pbs: Path) -> None:
    found = PBS.partition(None)
    assert found is not None and (found.name, found.up, found.limit_s, found.nodes) == ("workq", True, 259_200, None)
    assert PBS.partition("workq") == found and PBS.partition("long") is None


def test_workers_are_kept_up_and_all_units_are_solved_once(
    pbs: Path, store: UnitStore, units: tuple[Unit, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, seconds in {"POLL_S": 0.1, "FIRST_WAIT_S": 0.2}.items():
        monkeypatch.setattr(pool, name, seconds)
    profile = Profile.from_data(LEAST, "a")
    notes: list[str] = []
    with cluster_client(profile, store.folder, 5.0, notes.append) as client:
        client.wait_for_workers(2, timeout=60)
        assert states(pbs) == ["R", "R"]
        wait_until(lambda: all(job.came_up for job in client.cluster.workers.values()))
        os.killpg(stand_in_pbs.jobs(pbs)["1"]["pid"], signal.SIGKILL)
        wait_until(lambda: states(pbs) == ["F", "R", "R"])
        client.wait_for_workers(2, timeout=60)
    assert any("1 workers ended, replaced by new jobs" in note for note in notes)
    wait_until(lambda: set(states(pbs)) == {"F"})
    run_units(units, store, lambda: cluster_client(profile, store.folder, 5.0), solve="fakes:steady")
    wait_until(lambda: set(states(pbs)) == {"F"})
    assert store.solved() == {unit.digest for unit in units}
    starts = [entry.unit for entry in read_journal(store.folder / "journal") if entry.event == "start"]
    assert len(starts) == len(set(starts)) == len(units)
    assert "Start worker at" in (store.folder / "logs" / "worker-2.log").read_text()


def test_the_doctor_finds_it_sound(pbs: Path, tmp_path: Path) -> None:
    profile = Profile.from_data(LEAST | {"driver": {"walltime": "24:00:00"}}, "a")
    findings = {finding.check: finding for finding in examine(profile, tmp_path / "runs", 60.0)}
    assert all(finding.ok for finding in findings.values()), findings
    assert findings["qsub"].text == "pbs_version = stand-in"
    assert findings["partition of the workers"].text == "workq: at most 72 h"
    assert findings["job"].ok and findings["clock"].ok and findings["interface"].ok


class Driver:
    """The driver's script in the stand-in's queue, with a program in Python's place that writes down its calls."""

    def __init__(self, folder: Path, behaviour: str) -> None:
        self.run = folder / "run"
        for name in ("cluster", "logs"):
            (self.run / name).mkdir(parents=True)
        self.calls = folder / "calls"
        python = folder / "python"
        python.write_text(f'#!/bin/bash\necho "$4 $GAITFLOW_DRIVER_JOB" >> {self.calls}\n{behaviour}\n')
        python.chmod(0o755)
        kept = self.run / "cluster" / "driver.sh"
        profile = Profile.from_data(LEAST | {"driver": {"walltime": "00:05:00"}}, "a")
        text = driver_script(PBS, profile, self.run, folder, "s", self.run / "p.yaml", kept, str(python))
        self.text = text.replace("sleep 240 &", "sleep 2 &")
        assert self.text != text
        kept.write_text(self.text)

    def lines(self) -> list[str]:
        return self.calls.read_text().splitlines() if self.calls.exists() else []


SLEEPS = 'trap "exit 1" TERM; sleep 60 & wait'


def restarts(folder: Path) -> list[str]:
    return [job["options"]["-v"].partition("GAITFLOW_RESTARTS=")[2] for job in stand_in_pbs.jobs(folder).values()]


def test_a_driver_solves_and_runs_the_other_stages(pbs: Path, tmp_path: Path) -> None:
    made = Driver(tmp_path, "exit 0")
    PBS.submit(made.text)
    wait_until(lambda: states(pbs) == ["F"])
    assert made.lines() == [f"{tmp_path} 1"] * 2 and stand_in_pbs.jobs(pbs)["1"]["code"] == 0


@pytest.mark.parametrize("behaviour", [SLEEPS, "[ -e $0.killed ] && exit 0; touch $0.killed; kill -9 $$"])
def test_a_driver_that_is_killed_or_near_its_walltime_comes_back_as_a_new_job(
    pbs: Path, tmp_path: Path, behaviour: str
) -> None:
    made = Driver(tmp_path, behaviour)
    PBS.submit(made.text)
    wait_until(lambda: len(states(pbs)) >= 2 and states(pbs)[0] == "F")
    assert restarts(pbs)[:2] == ["", "1"]
    later = stand_in_pbs.jobs(pbs)["2"]
    assert later["options"]["-v"].startswith(f"GAITFLOW_JOB={job_mark(made.run, 'driver')},")
    wait_until(lambda: f"{tmp_path} 2" in made.lines())
    # The end of the run, also of drivers that come back for ever.
    (pbs / "refuse").write_text("enough")
    wait_until(lambda: set(states(pbs)) == {"F"})


def test_a_driver_that_is_cancelled_or_was_killed_too_often_stays_away(pbs: Path, tmp_path: Path) -> None:
    made = Driver(tmp_path, SLEEPS)
    PBS.submit(made.text.replace("sleep 2 &", "sleep 60 &"))
    wait_until(made.lines)
    PBS.cancel(["1"])
    wait_until(lambda: states(pbs) == ["F"])
    (tmp_path / "python").write_text("#!/bin/bash\nkill -9 $$\n")
    mark = f"GAITFLOW_JOB={job_mark(made.run, 'driver')}"
    command = ["qsub", "-v", f"{mark},GAITFLOW_RESTARTS={RESTARTS}", str(made.run / "cluster" / "driver.sh")]
    subprocess.run(command, check=True, capture_output=True)
    wait_until(lambda: states(pbs) == ["F", "F"])
    assert stand_in_pbs.jobs(pbs)["2"]["code"] == 128 + signal.SIGKILL


def gaitflow(*arguments: str) -> Result:
    return CliRunner().invoke(main, list(arguments))


def data_of(*arguments: str) -> Any:
    done = gaitflow(*arguments, "--json")
    assert done.exit_code == 0, done.output
    return json.loads(done.output)


def test_submit_status_and_cancel(pbs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (pbs / "hold").touch()
    (tmp_path / "here.yaml").write_text(json.dumps(LEAST))
    said = data_of("submit", "quickstart", "--profile", "here.yaml")
    run = tmp_path / "runs" / "quickstart"
    assert said["job"] == "1" and (run / "cluster" / "driver.sh").read_text() == said["driver"]
    assert "driver 1 pending; waiting for Not Running: Not enough free nodes" in gaitflow("status", "quickstart").output
    assert data_of("status", "quickstart")["jobs"]["driver"] == {"PENDING": 1}
    second = gaitflow("submit", "quickstart", "--profile", "here.yaml")
    assert second.exit_code == 1 and "driver job 1 is pending" in second.output
    assert [job["role"] for job in data_of("cancel", "quickstart")["cancelled"]] == ["driver"]
    (run / "cluster" / "jobs.json").unlink()  # a listing is believed for half a minute
    assert states(pbs) == ["F"] and data_of("status", "quickstart")["jobs"]["driver"] == {}


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_submitted_once_it_makes_the_map(pbs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = (CHECKOUT / "configs" / "scenarios" / "quickstart.yaml").read_text()
    coarse = text.replace("knots_per_phase: 10", "knots_per_phase: 3").replace("name: quickstart", "name: coarse")
    assert coarse.count("coarse") == coarse.count("knots_per_phase: 3") == 1
    (tmp_path / "coarse.yaml").write_text(coarse)
    (tmp_path / "here.yaml").write_text(json.dumps(LEAST))
    data_of("submit", "coarse.yaml", "--profile", "here.yaml")
    wait_until(lambda: set(states(pbs)) == {"F"}, 500)
    run = tmp_path / "runs" / "coarse"
    log = (run / "logs" / "driver-1.log").read_text()
    assert stand_in_pbs.jobs(pbs)["1"]["code"] == 0, log
    state = data_of("status", "coarse.yaml")
    assert (state["left"], state["failed"], state["solved"]) == (0, 0, state["units"])
    starts = [entry.unit for entry in read_journal(run / "journal") if entry.event == "start"]
    assert len(starts) == len(set(starts)), "a unit was solved more than once"
    assert list((tmp_path / "models" / "coarse").iterdir()) and list((run / "report").glob("*.html"))
