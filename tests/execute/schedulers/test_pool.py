"""The pool of workers that are jobs, with commands in Slurm's place; tests/slurm has the real ones."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from gaitflow.config.cluster import Profile
from gaitflow.execute.drivers import IN_DRIVER_JOB
from gaitflow.execute.run import RunFailed, run_units
from gaitflow.execute.schedulers import jobs, pool
from gaitflow.execute.schedulers.base import job_mark
from gaitflow.execute.schedulers.cluster_client import cluster_client
from gaitflow.execute.schedulers.pool import WorkerPool
from gaitflow.execute.schedulers.slurm import Slurm
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit

PROFILE = Profile(name="here", walltime="01:00:00", jobs=2, interface="lo", tls=False)


class Commands:
    """sbatch, squeue and scancel over a folder: `queue` has a line a job, `refuse` the reason of refusals."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        folder.mkdir()
        (folder / "queue").touch()
        (folder / "asked").touch()
        text = {
            "sbatch": 'echo sbatch >> asked; [ -e refuse ] && { echo "sbatch: error: $(cat refuse)" >&2; exit 1; }\n'
            'id=$(wc -l < asked); mark=$(grep -o "gaitflow:[^ ]*" "$script")\n'
            'echo "$id|PENDING|w|$mark|Priority" >> queue; [ -e slow ] && sleep 1; echo "Submitted batch job $id"',
            "squeue": "[ -e down ] && { echo 'Unable to contact slurm controller' >&2; exit 1; }; cat queue",
            "scancel": 'shift; for id; do sed -i "/^$id|/d" queue; echo "$id" >> cancelled; done',
        }
        for name, body in text.items():
            (folder / name).write_text(
                f'#!/bin/bash\nscript=$(realpath "$1")\ncd {folder}\nexec 9>lock; flock 9\n{body}\n'
            )
            (folder / name).chmod(0o755)

    def queue(self) -> list[str]:
        return [line.partition("|")[0] for line in (self.folder / "queue").read_text().splitlines()]

    def submissions(self) -> int:
        return len((self.folder / "asked").read_text().splitlines())

    def cancelled(self) -> set[str]:
        file = self.folder / "cancelled"
        return set(file.read_text().split()) if file.exists() else set()

    def set(self, **files: str | None) -> None:
        for name, text in files.items():
            path = self.folder / name
            path.unlink(missing_ok=True)
            if text is not None:
                path.write_text(text)


@pytest.fixture
def slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Commands:
    slurm = Commands(tmp_path / "bin")
    monkeypatch.setenv("PATH", f"{slurm.folder}:/usr/bin:/bin")
    monkeypatch.delenv(IN_DRIVER_JOB, raising=False)
    monkeypatch.setattr(jobs, "ASK_EVERY_S", 0.2)
    for name, seconds in {"POLL_S": 0.05, "FIRST_WAIT_S": 0.1, "LONGEST_WAIT_S": 0.3}.items():
        monkeypatch.setattr(pool, name, seconds)
    return slurm


@pytest.fixture
def notes() -> list[str]:
    return []


@pytest.fixture
def worker_pool(slurm: Commands, store: UnitStore, notes: list[str]) -> Iterator[WorkerPool]:
    (store.folder / "logs").mkdir(parents=True)
    with WorkerPool(Slurm(), PROFILE, store.folder, 5.0, None, notes.append) as made:
        yield made
        made.end_jobs()


def wait_until(condition: Callable[[], object], seconds: float = 20.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "it took too long"
        time.sleep(0.02)


def test_jobs_that_wait_are_left_alone_and_lost_ones_replaced(
    worker_pool: WorkerPool, slurm: Commands, notes: list[str]
) -> None:
    worker_pool.keep_up()
    wait_until(lambda: len(slurm.queue()) == 2)
    time.sleep(1.0)
    assert slurm.submissions() == 2 and notes == []
    lost, kept = slurm.queue()
    slurm.set(queue="".join(line for line in (slurm.folder / "queue").open() if not line.startswith(f"{lost}|")))
    wait_until(lambda: len(slurm.queue()) == 2)
    assert kept in slurm.queue() and slurm.submissions() == 3
    assert len(notes) == 1 and notes[0].startswith("1 jobs ended before their worker came up")


def test_jobs_that_nobody_knows_are_ended_and_other_runs_left_alone(
    worker_pool: WorkerPool, slurm: Commands, store: UnitStore
) -> None:
    rows = [("900", job_mark(store.folder, "old-0")), ("901", job_mark(store.folder, "driver"))]
    rows.append(("902", job_mark(store.folder.parent / "other", "old-0")))
    slurm.set(queue="".join(f"{id}|RUNNING|w|{mark}|None\n" for id, mark in rows))
    worker_pool.keep_up()
    wait_until(lambda: slurm.cancelled() == {"900"} and len(slurm.queue()) == 4)
    assert {"901", "902"} < set(slurm.queue())


def test_the_end_of_the_pool_ends_its_jobs(slurm: Commands, store: UnitStore) -> None:
    (store.folder / "logs").mkdir(parents=True)
    with WorkerPool(Slurm(), PROFILE, store.folder, 5.0, None) as made:
        made.keep_up()
        wait_until(lambda: len(slurm.queue()) == 2)
        made.end_jobs()
    assert slurm.queue() == [] and slurm.submissions() == 2


def test_jobs_whose_submission_is_not_answered_yet_are_ended_too(slurm: Commands, store: UnitStore) -> None:
    (store.folder / "logs").mkdir(parents=True)
    slurm.set(slow="")
    with WorkerPool(Slurm(), PROFILE, store.folder, 5.0, None) as made:
        made.keep_up()
        wait_until(slurm.queue)
        made.end_jobs()
    assert slurm.queue() == [] and slurm.submissions() == 2


def test_refusals_are_told_and_tried_again(worker_pool: WorkerPool, slurm: Commands, notes: list[str]) -> None:
    slurm.set(refuse="Batch job submission failed: Job violates accounting/QOS policy")
    worker_pool.keep_up()
    wait_until(lambda: slurm.submissions() >= 6)
    assert worker_pool.hopeless == ""
    slurm.set(refuse=None)
    wait_until(lambda: len(slurm.queue()) == 2)
    assert "sbatch failed for 2 jobs" in notes[0] and "violates accounting/QOS policy" in notes[0]


def test_refusals_without_end_end_the_run(
    slurm: Commands, store: UnitStore, units: tuple[Unit, ...], notes: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pool, "GIVE_UP_S", 1.5)
    slurm.set(refuse="Batch job submission failed: Invalid account or account/partition combination specified")
    begin = time.monotonic()
    with pytest.raises(RunFailed) as failed:
        run_units(units, store, lambda: cluster_client(PROFILE, store.folder, 5.0, notes.append), solve="fakes:steady")
    assert time.monotonic() - begin > 1.5
    said = str(failed.value)
    assert "Invalid account or account/partition combination specified" in said
    assert "0 of 6 units are stored" in said and "run the same command again" in said
    assert slurm.submissions() >= 6 and slurm.queue() == []


@pytest.mark.parametrize("hope", ["a job waits", "the controller is away"])
def test_a_run_goes_on_while_there_is_hope(
    worker_pool: WorkerPool, slurm: Commands, hope: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pool, "GIVE_UP_S", 1.0)
    if hope == "a job waits":
        worker_pool.keep_up()
        wait_until(lambda: len(slurm.queue()) == 2)
        slurm.set(queue=(slurm.folder / "queue").read_text().splitlines()[0] + "\n", refuse="QOSMaxSubmitJobLimit")
    else:
        slurm.set(down="", refuse="Unable to contact slurm controller")
        worker_pool.keep_up()
    before = slurm.submissions()
    begin = time.monotonic()
    wait_until(lambda: slurm.submissions() >= before + 6 and time.monotonic() > begin + 2.5)
    assert worker_pool.hopeless == ""
    if hope == "a job waits":
        slurm.set(queue="")
    else:
        slurm.set(down=None)
    wait_until(lambda: worker_pool.hopeless)
