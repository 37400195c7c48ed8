"""Slurm's commands, played by small scripts that write down what they were asked."""

from __future__ import annotations

import getpass
import json
import os
import time
from pathlib import Path

import pytest

from gaitflow.execute.drivers import IN_DRIVER_JOB, DriverAlive, driver_process, refuse_second_driver, the_driver
from gaitflow.execute.schedulers import jobs
from gaitflow.execute.schedulers.base import SchedulerError, job_mark
from gaitflow.execute.schedulers.jobs import Queue, cancel_run, jobs_of
from gaitflow.execute.schedulers.slurm import Slurm, job_id, parse_queue

SLURM = Slurm()


class Commands:
    """sbatch, squeue, sinfo and scancel with answers of our own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        folder.mkdir()

    def answers(self, name: str, text: str = "", code: int = 0, error: str = "") -> None:
        (self.folder / f"{name}.out").write_text(text)
        (self.folder / f"{name}.err").write_text(error)
        program = self.folder / name
        program.write_text(
            f'#!/bin/bash\necho "$*" >> {self.folder}/{name}.calls\ncat {self.folder}/{name}.out\n'
            f"cat {self.folder}/{name}.err >&2\nexit {code}\n"
        )
        program.chmod(0o755)

    def calls(self, name: str) -> list[str]:
        file = self.folder / f"{name}.calls"
        return file.read_text().splitlines() if file.exists() else []


@pytest.fixture
def commands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Commands:
    made = Commands(tmp_path / "bin")
    monkeypatch.setenv("PATH", f"{made.folder}:/usr/bin:/bin")
    monkeypatch.delenv(IN_DRIVER_JOB, raising=False)
    for name in ("sbatch", "squeue", "scancel"):
        made.answers(name)
    return made


@pytest.fixture
def run(tmp_path: Path) -> Path:
    folder = tmp_path / "runs" / "quickstart"
    (folder / "cluster").mkdir(parents=True)
    return folder


def listing(run: Path) -> str:
    other = run.parent / "other"
    return (
        f"11|RUNNING|gaitflow-quickstart-driver|{job_mark(run, 'driver')}|None\n"
        f"12|PENDING|gaitflow-quickstart-worker|{job_mark(run, 'ab-0')}|Resources | or so\n"
        f"13|COMPLETING|gaitflow-quickstart-worker|{job_mark(run, 'ab-1')}|None\n"
        f"14|RUNNING|gaitflow-quickstart-worker|{job_mark(other, 'ab-2')}|None\n"
        "15|RUNNING|gaitflow-quickstart-worker|(null)|None\n"
        "some warning\n"
    )


def test_only_jobs_with_the_run_s_mark_are_its_jobs(run: Path) -> None:
    found = parse_queue(listing(run), job_mark(run, ""))
    assert [(job.id, job.role, job.alive) for job in found] == [
        ("11", "driver", True),
        ("12", "ab-0", True),
        ("13", "ab-1", False),
    ]
    assert found[1].reason == "Resources | or so"


def test_cancel_ends_the_run_s_jobs_and_no_others_the_driver_first(commands: Commands, run: Path) -> None:
    commands.answers("squeue", listing(run))
    assert [job.id for job in cancel_run(run, SLURM)] == ["11", "12"]
    assert commands.calls("scancel") == ["--quiet 11 12"]
    assert f"--user={os.getuid()}" in commands.calls("squeue")[0]


def test_nothing_to_cancel_is_no_error_and_asks_for_nothing(commands: Commands, run: Path) -> None:
    assert cancel_run(run, SLURM) == ()
    assert commands.calls("scancel") == []


def test_many_jobs_are_cancelled_by_few_commands(commands: Commands) -> None:
    SLURM.cancel(str(number) for number in range(1200))
    assert [len(call.split()) for call in commands.calls("scancel")] == [501, 501, 201]


def test_a_listing_is_shared_by_all_who_ask_within_half_a_minute(commands: Commands, run: Path) -> None:
    commands.answers("squeue", listing(run))
    first = jobs_of(run, SLURM)
    assert jobs_of(run, SLURM) == first and len(commands.calls("squeue")) == 1
    kept = run / "cluster" / "jobs.json"
    data = json.loads(kept.read_text())
    kept.write_text(json.dumps(data | {"time": time.time() - 31}))
    assert jobs_of(run, SLURM) == first and len(commands.calls("squeue")) == 2
    kept.write_text("{")
    assert jobs_of(run, SLURM) == first and len(commands.calls("squeue")) == 3
    assert jobs_of(run, SLURM, max_age_s=0) == first and len(commands.calls("squeue")) == 4


def test_asking_about_a_run_that_never_was_on_a_cluster_writes_nothing(commands: Commands, tmp_path: Path) -> None:
    assert jobs_of(tmp_path / "runs" / "new", SLURM) == ()
    assert not (tmp_path / "runs").exists()


def test_a_queue_asks_every_half_minute_at_most(commands: Commands, run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    commands.answers("squeue", listing(run))
    now = time.monotonic()
    monkeypatch.setattr(jobs.time, "monotonic", lambda: now)
    queue = Queue(run, SLURM)
    news = queue.news()
    assert news is not None and len(news[0]) == 3 and news[1] == now
    for _ in range(5):
        assert queue.news() is None
    now += 29.9
    assert queue.news() is None
    now += 0.2
    commands.answers("squeue", code=1, error="slurm_load_jobs error: Unable to contact slurm controller\n")
    with pytest.raises(SchedulerError, match="Unable to contact"):
        queue.news()
    assert queue.news() is None, "also after a failure"
    assert len(commands.calls("squeue")) == 2


@pytest.mark.parametrize(("answer", "number"), [("42\n", "42"), ("42;cluster2\n", "42"), ("a notice\n7\n", "7")])
def test_the_id_in_sbatch_s_answer(answer: str, number: str) -> None:
    assert job_id(answer) == number


@pytest.mark.parametrize("answer", ["", "Submitted", "4x2"])
def test_an_answer_without_an_id_is_told(answer: str) -> None:
    with pytest.raises(SchedulerError, match="no job id"):
        job_id(answer)


def test_what_sbatch_says_is_passed_on(commands: Commands) -> None:
    commands.answers("sbatch", code=1, error="sbatch: error: Batch job submission failed: Invalid account\n")
    with pytest.raises(SchedulerError, match=r"^sbatch: Batch job submission failed: Invalid account$"):
        SLURM.submit("#!/bin/bash\n")


def test_a_machine_without_slurm_is_told_so(monkeypatch: pytest.MonkeyPatch, run: Path) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(SchedulerError, match="squeue: not found; run this where Slurm is"):
        jobs_of(run, SLURM)


@pytest.mark.parametrize(
    ("text", "seconds"), [("infinite", None), ("30:00", 1800), ("2:00:00", 7200), ("2-00:00:00", 172_800)]
)
def test_limits_of_partitions(commands: Commands, text: str, seconds: int | None) -> None:
    commands.answers("sinfo", f"long|long|up|10|4\nshort|short*|up|{text}|3\n")
    found = SLURM.partition(None)
    assert found is not None and (found.name, found.limit_s, found.nodes, found.up) == ("short", seconds, 3, True)


def test_a_second_driver_is_refused_with_the_way_out(commands: Commands, run: Path) -> None:
    commands.answers("squeue", listing(run))
    with pytest.raises(DriverAlive, match=r"driver job 11 is running; .*gaitflow cancel quickstart"):
        refuse_second_driver(run, SLURM)
    commands.answers("squeue", "")
    refuse_second_driver(run, SLURM)


def start_of(pid: int) -> str:
    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[19]


def test_a_process_that_drives_is_known_until_it_ends(commands: Commands, run: Path) -> None:
    with the_driver(run, SLURM):
        record = json.loads((run / "driver.json").read_text())
        assert record["pid"] == os.getpid()
        (run / "driver.json").write_text(json.dumps(record | {"pid": os.getppid(), "started": start_of(os.getppid())}))
        with pytest.raises(DriverAlive, match=rf"the process {os.getppid()} of {getpass.getuser()} on \S+ solves it"):
            refuse_second_driver(run, SLURM)
    assert driver_process(run) is None
    (run / "driver.json").write_text(json.dumps(record | {"pid": 2**22 + 1}))
    refuse_second_driver(run, SLURM)  # it was killed
    (run / "driver.json").write_text(json.dumps(record | {"pid": os.getppid(), "started": "1"}))
    refuse_second_driver(run, SLURM)  # it was killed, and its number is another process's now
    (run / "driver.json").write_text(json.dumps(record | {"host": "elsewhere"}))
    with pytest.raises(DriverAlive, match=r"on elsewhere solves it; end that one first, or remove .*driver\.json"):
        refuse_second_driver(run, SLURM)


def test_a_driver_job_that_comes_back_is_not_its_own_rival(
    commands: Commands, run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    commands.answers("squeue", listing(run))
    monkeypatch.setenv(IN_DRIVER_JOB, "11")
    with the_driver(run, SLURM):
        assert commands.calls("squeue") == []
