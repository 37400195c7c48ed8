"""One test a fault: the run ends, its dataset is the undisturbed one, no stored unit is solved again, no job is left.

With GAITFLOW_SLURM_FAULTS set to a path, the measurements are written there as a bench document.
"""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from cluster import NODES, Cluster, program_path
from disturbed import POOL, SLOW_S, Row, Run, undisturbed

from gaitflow.config.scenario import Scenario, load_scenario

pytestmark = [pytest.mark.slurm, pytest.mark.slow, pytest.mark.timeout(400)]

UNITS = 90


@pytest.fixture(scope="module")
def scenario(checkout: Path) -> Scenario:
    """The half-cheetah at 90 speeds, one a unit."""
    data = load_scenario(checkout / "configs/scenarios/quickstart.yaml").as_data()
    data["tasks"] = {"axes": {"speed": {"start": 0.1, "stop": 2.1, "count": UNITS}, "cycle_duration": 0.5}}
    data["strategy"]["tasks_per_unit"] = 1
    return Scenario.from_data(data, "faults")


@pytest.fixture(scope="module")
def reference(scenario: Scenario, tmp_path_factory: pytest.TempPathFactory) -> pd.DataFrame:
    frame = undisturbed(scenario, tmp_path_factory.mktemp("undisturbed"))
    assert len(frame) == UNITS
    return frame


@pytest.fixture
def make_run(cluster: Cluster, scenario: Scenario, tmp_path: Path) -> Iterator[Callable[..., Run]]:
    made: list[Run] = []

    def make(folder: Path = tmp_path, **profile: Any) -> Run:
        made.append(Run(cluster, scenario, folder, **profile))
        return made[-1]

    yield make
    for run in made:
        run.close()


@pytest.fixture
def run(make_run: Callable[..., Run]) -> Run:
    """A run whose solvers are all at work."""
    run = make_run()
    run.start()
    run.wait_for_pool()
    return run


@pytest.fixture
def small_disk() -> Iterator[Callable[[Path], None]]:
    """Mounts a file system of its own, of 32 MB, in a new folder."""
    sudo = [] if os.geteuid() == 0 else ["sudo", "-n"]
    mounted: list[Path] = []

    def mount(folder: Path) -> None:
        folder.mkdir(parents=True)
        options = f"size=32m,uid={os.getuid()},mode=0700"
        done = subprocess.run([*sudo, "mount", "-t", "tmpfs", "-o", options, "tmpfs", folder], capture_output=True)
        if done.returncode:
            pytest.skip(f"a file system cannot be mounted here: {done.stderr.decode().strip()}")
        mounted.append(folder)

    yield mount
    for folder in mounted:
        subprocess.run([*sudo, "umount", "--lazy", folder], check=True)


@pytest.fixture
def judge(reference: pd.DataFrame, record_row: Callable[[Row], None]) -> Callable[..., None]:
    def judge(run: Run, fault: str, hit: Collection[int], recovered_s: float | None) -> None:
        """Wait for the end of the run and hold it against the undisturbed one."""
        assert run.finish() == 0, run.log[-3000:]
        row = run.row(fault, hit, recovered_s)
        record_row(row)
        assert row.ended and row.repeated == 0, row
        assert row.lost_in_flight > 0 or not hit, "the fault hit no unit: the test has shown nothing"
        pd.testing.assert_frame_equal(run.dataset(), reference)

    return judge


def test_nothing_happens(make_run: Callable[..., Run], judge: Callable[..., None]) -> None:
    run = make_run()
    begin = time.time()
    run.start()
    judge(run, "none", (), run.wait_for_pool() - begin)


def test_a_worker_is_cancelled(run: Run, judge: Callable[..., None], cluster: Cluster) -> None:
    job = run.jobs()[0]
    hit, begin = run.solvers(job), time.time()
    assert len(hit) == 1
    cluster.call("scancel", job)
    judge(run, "scancel", hit, run.wait_for_pool(hit) - begin)
    assert run.lost_solves() == 0, "a worker that was asked to end counts as a lost one"


def test_workers_are_preempted(run: Run, judge: Callable[..., None], cluster: Cluster) -> None:
    hit, begin = run.solvers(), time.time()
    urgent = [urgent_job(cluster, node) for node in NODES]
    run.wait_until(lambda: set(urgent) <= set(running(cluster, "urgent")))
    judge(run, "preemption", hit, run.wait_for_pool(hit) - begin)
    assert run.lost_solves() == 0, "a worker that was asked to end counts as a lost one"


def test_a_node_is_taken_down(run: Run, judge: Callable[..., None], cluster: Cluster) -> None:
    node = busiest(cluster)
    hit, begin = run.solvers(), time.time()
    cluster.set_node(node, "down")
    judge(run, "node down", hit, run.wait_for_pool(hit) - begin)


def test_a_node_dies(run: Run, judge: Callable[..., None], cluster: Cluster) -> None:
    node = busiest(cluster)
    hit, begin = run.solvers(), time.time()
    cluster.kill_node(node)
    judge(run, "node dead", hit, run.wait_for_pool(hit) - begin)
    assert run.lost_solves() == len(hit)


def test_the_controller_is_away_while_a_worker_dies(run: Run, judge: Callable[..., None], cluster: Cluster) -> None:
    job = run.jobs()[0]
    hit, begin = run.solvers(job), time.time()
    cluster.kill_controller()
    for pid in cluster.job_processes(job=job):
        os.kill(pid, signal.SIGKILL)
    time.sleep(20)
    cluster.start_controller()
    judge(run, "controller away", hit, run.wait_for_pool(hit) - begin)


def test_sbatch_fails_three_times(
    make_run: Callable[..., Run], judge: Callable[..., None], cluster: Cluster, tmp_path: Path
) -> None:
    run, wrapper, count = make_run(), tmp_path / "bin" / "sbatch", tmp_path / "failures"
    wrapper.parent.mkdir()
    real = program_path("sbatch")
    wrapper.write_text(
        f"#!/bin/bash\nif [ \"$(cat '{count}' 2>/dev/null | wc -l)\" -lt 3 ]; then\n"
        f"  echo failed >> '{count}'; echo 'sbatch: error: Socket timed out on send/recv operation' >&2; exit 1\nfi\n"
        f'exec {real} "$@"\n'
    )
    wrapper.chmod(0o755)
    begin = time.time()
    run.start(PATH=f"{wrapper.parent}:{os.environ['PATH']}")
    judge(run, "sbatch fails", (), run.wait_for_pool() - begin)
    assert count.read_text().count("failed") == 3 and "Socket timed out" in run.log


def test_the_driver_is_killed_and_started_again(run: Run, judge: Callable[..., None]) -> None:
    hit, begin = run.solvers(), time.time()
    run.kill_driver()
    run.start()
    judge(run, "driver killed", hit, run.wait_for_pool(hit) - begin)


def test_the_scheduler_is_killed_in_its_job(make_run: Callable[..., Run], judge: Callable[..., None]) -> None:
    """It lives in the driver's process; the driver's job puts itself back into the queue."""
    run = make_run()
    run.submit()
    run.wait_for_pool()
    hit, begin = run.solvers(), time.time()
    os.kill(run.driver(), signal.SIGKILL)
    judge(run, "scheduler killed", hit, run.wait_for_pool(hit) - begin)


def test_the_drivers_job_is_preempted_and_requeued(
    make_run: Callable[..., Run], judge: Callable[..., None], cluster: Cluster
) -> None:
    """And all workers with it, as they are on its node."""
    run = make_run()
    job = run.submit()
    run.wait_for_pool()
    hit, begin = run.solvers(), time.time()
    urgent = urgent_job(cluster, busiest(cluster))
    run.wait_until(lambda: urgent in running(cluster, "urgent"))
    judge(run, "driver requeued", hit, run.wait_for_pool(hit) - begin)
    assert cluster.completed().count(f"JobId={job} ") >= 2, "it was not requeued"


def test_the_disk_of_the_store_is_full(
    make_run: Callable[..., Run], judge: Callable[..., None], small_disk: Callable[[Path], None]
) -> None:
    """The run says so and ends; once there is room again, the next one goes on."""
    run = make_run()
    small_disk(run.store.folder)
    run.start()
    run.wait_for_pool()
    hit, ballast = run.solvers(), fill(run.store.folder)
    assert run.finish() == 1, "the run went on, though nothing can be stored"
    assert "No space left on device" in run.log and "free some space on that disk and run again" in run.log
    ballast.unlink()
    run.pace(SLOW_S)
    begin = time.time()
    run.start()
    judge(run, "store full", hit, run.wait_for_pool(hit) - begin)


def test_the_scratch_disk_of_the_nodes_is_full(
    make_run: Callable[..., Run],
    judge: Callable[..., None],
    small_disk: Callable[[Path], None],
    cluster: Cluster,
    tmp_path: Path,
) -> None:
    """Workers go on; one that is lost meanwhile is replaced once there is room again."""
    scratch = tmp_path / "scratch"
    small_disk(scratch)
    run = make_run(scratch=str(scratch))
    run.start()
    run.wait_for_pool()
    job, before = run.jobs()[0], len(run.store.solved())
    hit, ballast, begin = run.solvers(job), fill(scratch), time.time()
    cluster.call("scancel", job)
    run.wait_until(lambda: len(run.store.solved()) >= before + 6)
    time.sleep(max(0.0, begin + 10 - time.time()))
    ballast.unlink()
    judge(run, "scratch full", hit, run.wait_for_pool(hit) - begin)
    assert not run.store.attempts.folder.exists(), "it cost units an attempt"


def test_a_walltime_ends(make_run: Callable[..., Run], judge: Callable[..., None], cluster: Cluster) -> None:
    """A unit that hangs beyond its worker's walltime: Slurm ends the job. The other workers end before theirs."""
    run = make_run(walltime="00:01:00")
    run.pace(2 * SLOW_S)  # Slurm looks at walltimes every half a minute: the others must not be done by then
    run.start("fakes:hangs_first")
    run.wait_until(lambda: list(run.marks.glob("hangs-*")))
    hit = {int(mark.name.partition("-")[2]) for mark in run.marks.glob("hangs-*")}
    run.wait_until(lambda: "JobState=TIMEOUT" in cluster.completed(), 150)
    begin = time.time()
    judge(run, "walltime", hit, run.wait_for_pool(hit) - begin)
    solvers = {entry.solver for entry in run.journal()}
    assert len(solvers) >= 2 * POOL, "no worker came to the end of its lifetime"
    starts = sum(entry.event == "start" for entry in run.journal())
    assert starts == UNITS + 1, "a worker that ended at its lifetime lost the unit in work"


def test_a_unit_takes_more_memory_than_its_job_has(
    make_run: Callable[..., Run], judge: Callable[..., None], cluster: Cluster
) -> None:
    """Slurm kills the job, worker and all."""
    run = make_run()
    run.start("fakes:hoards_first")
    run.wait_until(lambda: list(run.marks.glob("hoards-*")))
    hit, begin = {int(mark.name.partition("-")[2]) for mark in run.marks.glob("hoards-*")}, time.time()
    run.wait_until(lambda: not hit & run.solvers())
    judge(run, "out of memory", hit, run.wait_for_pool(hit) - begin)
    logs = "".join(log.read_text(errors="replace") for log in run.store.folder.glob("logs/worker-*.log"))
    assert "exceeded memory limit" in logs, "something else ended it"


@pytest.mark.parametrize(
    ("solver", "reason"), [("dies_at_first", "crashed: SIGSEGV x3"), ("kills_its_worker", "its worker was lost")]
)
def test_a_poison_unit_is_given_up(
    make_run: Callable[..., Run],
    reference: pd.DataFrame,
    record_row: Callable[[Row], None],
    solver: str,
    reason: str,
) -> None:
    """One that kills the solver, and one that kills the worker, too."""
    run = make_run()
    run.pace(0.3)
    run.start(f"fakes:{solver}")
    run.wait_until(run.store.attempts.given_up)
    assert run.finish() == 0, run.log[-3000:]
    row = run.row("poison unit" if solver == "dies_at_first" else "poison, kills worker", (), None)
    record_row(row)
    assert row.ended and row.repeated == 0, row
    frame = run.dataset()
    poison = frame["speed"] == 0.1
    (said,) = frame[poison]["solver_status"]
    assert said.startswith(reason)
    pd.testing.assert_frame_equal(frame[~poison], reference[reference["speed"] != 0.1])


def busiest(cluster: Cluster) -> str:
    """The node on which all jobs are: Slurm fills one after the other."""
    nodes = set(cluster.call("squeue", "-h", "-t", "running", "-o", "%N").split())
    assert len(nodes) == 1, nodes
    return nodes.pop()


def fill(folder: Path) -> Path:
    """Write a file until its disk is full."""
    ballast = folder / "ballast"
    with suppress(OSError), open(ballast, "wb", buffering=0) as file:
        while file.write(bytes(1 << 12)):
            pass
    return ballast


def urgent_job(cluster: Cluster, node: str) -> str:
    """Submit a job that takes a whole node for ten seconds, whoever is there; its id."""
    options = ("-p", "urgent", "-w", node, "--exclusive", "-o", "/dev/null", "--wrap", "sleep 10")
    return cluster.call("sbatch", "--parsable", *options).strip()


def running(cluster: Cluster, partition: str) -> list[str]:
    return cluster.call("squeue", "-h", "-t", "running", "-p", partition, "-o", "%A").split()
