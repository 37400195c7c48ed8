"""A pool of workers that are jobs of a cluster, kept at its size whatever ends them.

dask-jobqueue submits one job for each worker. This module adds what it lacks. The wanted number is compared with the
workers that the scheduler sees and, every 30 s, with the jobs that are in the queue. That finds jobs that were lost
before their worker came up, jobs that were refused, and jobs that nobody knows. When all of them are refused for long,
it says so.
"""

from __future__ import annotations

import asyncio
import itertools
import secrets
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from dask_jobqueue.core import Job as DaskJob
from dask_jobqueue.core import JobQueueCluster
from distributed import Security, Status

from gaitflow.config.cluster import Profile
from gaitflow.execute.schedulers.base import DRIVER, Job, Scheduler, SchedulerError
from gaitflow.execute.schedulers.jobs import Queue
from gaitflow.execute.schedulers.scripts import worker_script

POLL_S = 1.0
STEP = 16  # jobs that are submitted before looking again
AT_ONCE = 4  # submissions side by side
FIRST_WAIT_S, LONGEST_WAIT_S = 5.0, 300.0  # between tries when submissions fail or workers do not come up
GIVE_UP_S = 1800.0  # of refusals, some ten tries, while no job waits or runs: a full queue may pass by then

OnNote = Callable[[str], None]


class WorkerJob(DaskJob):
    """One job with one worker. A submission that fails leaves its reason in `error` and no job id."""

    config_name = "slurm"  # any section of Dask's will do: nothing of it is used

    def __init__(
        self,
        scheduler: str | None = None,
        name: str | None = None,
        submit_command: str = "",
        write_script: Callable[[str, str], str] = lambda worker, scheduler: "",
        gate: asyncio.Semaphore | None = None,
        **options: Any,
    ) -> None:
        super().__init__(scheduler=scheduler, name=name, **options)
        self.submit_command = submit_command  # type: ignore[assignment]  # Dask's class has None
        self._write_script, self._gate = write_script, gate or asyncio.Semaphore()
        self.error = ""
        self.submitted = float("inf")  # time.monotonic() [s]
        self.came_up = False

    def job_script(self) -> str:
        """The text that is submitted."""
        return self._write_script(str(self.name), str(self.scheduler))

    async def start(self) -> None:
        """Submit the job; never raises for what the scheduler does."""
        try:
            async with self._gate:
                await super().start()
        except (RuntimeError, ValueError, OSError) as error:
            self.error = (str(error).strip().splitlines() or [type(error).__name__])[-1]
            self.status = Status.running
        self.submitted = time.monotonic()

    async def close(self) -> None:
        """Forget the job; the pool ends the jobs of many workers by one command."""
        self.status = Status.closed


class WorkerPool(JobQueueCluster):
    """A Dask cluster whose scheduler is here and whose `profile.jobs` workers are jobs.

    `hopeless` says why no worker is to be expected any more; it is "" while one is.
    """

    job_cls: type[DaskJob] = WorkerJob

    def __init__(
        self,
        scheduler: Scheduler,
        profile: Profile,
        run_folder: Path,
        longest_unit_s: float,
        security: Security | None,
        on_note: OnNote = lambda note: None,
    ) -> None:
        self._wanted, self._on_note = profile.jobs, on_note
        self._run_folder, self._jobs_scheduler = run_folder, scheduler
        self._numbers = itertools.count()
        self._listing = Queue(run_folder, scheduler)
        self._wait_s, self._not_before = 0.0, 0.0
        self._refused_since: float | None = None  # time.monotonic() [s]
        self.hopeless = ""
        self._keeper: asyncio.Task[None] | None = None

        def write_script(worker: str, address: str) -> str:
            return worker_script(scheduler, profile, run_folder, worker, address, longest_unit_s)

        super().__init__(
            name=secrets.token_hex(3),  # so that the workers of two sessions never have one name
            security=security,
            protocol="tls://" if security else "tcp://",
            interface=profile.interface,
            scheduler_options={"dashboard": False, "dashboard_address": "127.0.0.1:0"},
            cores=1,
            processes=1,
            memory=profile.memory,
            submit_command=scheduler.submit_command,
            write_script=write_script,
            gate=asyncio.Semaphore(AT_ONCE),
        )

    def keep_up(self) -> None:
        """Begin to submit and to replace jobs."""

        async def begin() -> None:
            self._keeper = asyncio.create_task(self._keep())

        self.sync(begin)

    def end_jobs(self) -> None:
        """Stop replacing jobs and end all of them. A worker that cannot be ended ends itself with the scheduler."""

        async def end() -> None:
            if self._keeper is not None:
                self._keeper.cancel()
                await asyncio.wait([self._keeper])
            await asyncio.wait([self._correct_state()])  # a job that is being submitted has no id yet
            await self._cancel([str(job.job_id) for job in self.workers.values() if job.job_id])

        self.sync(end)

    def _new_worker_name(self, worker_number: int) -> str:
        return f"{self._name}-{next(self._numbers)}"  # Dask's own would use a lost worker's name again

    async def _keep(self) -> None:
        while True:
            await self._reconcile()
            await asyncio.sleep(POLL_S)

    async def _reconcile(self) -> None:
        """One look: forget what is gone, cancel what nobody knows, submit what is missing."""
        assert self.scheduler is not None
        connected = {worker.name for worker in self.scheduler.workers.values()}
        for name in connected & self.workers.keys():
            if not self.workers[name].came_up:
                self.workers[name].came_up = True
                self._wait_s = 0.0
        listed = await self._listed()
        gone = {name: job for name, job in self.workers.items() if self._is_gone(job, name in connected, listed)}
        if gone:
            self._tell(gone)
            await self._cancel([str(job.job_id) for job in gone.values() if job.job_id])
            await self.scale_down(list(gone))
        self._judge([job.error for job in gone.values() if not job.job_id])
        if listed is not None:
            await self._cancel(self._strangers(listed[0]))
        missing = self._wanted - len(self.worker_spec)
        if missing > 0 and time.monotonic() >= self._not_before:
            self.scale(len(self.worker_spec) + min(missing, STEP))

    async def _listed(self) -> tuple[dict[str, Job], float] | None:
        """Living jobs by id and when they were listed; None when it is too early to ask, or nobody answers."""
        try:
            news = await asyncio.to_thread(self._listing.news)
        except SchedulerError as error:
            self._on_note(f"the queue cannot be read, workers go on: {error}")
            self._refused_since = None  # a controller that is away refuses nothing
            return None
        return None if news is None else ({job.id: job for job in news[0] if job.alive}, news[1])

    def _is_gone(self, job: WorkerJob, connected: bool, listed: tuple[dict[str, Job], float] | None) -> bool:
        if not job.job_id or (job.came_up and not connected):
            return True
        return listed is not None and job.submitted < listed[1] and job.job_id not in listed[0]

    def _strangers(self, listed: dict[str, Job]) -> list[str]:
        """Workers' jobs of this run that are not of this pool: of a session that was killed, or submitted unheard."""
        known = {job.job_id for job in self.workers.values()}
        coming = self.worker_spec.keys() - self.workers.keys()
        return [id for id, job in listed.items() if job.role != DRIVER and id not in known and job.role not in coming]

    def _tell(self, gone: dict[str, WorkerJob]) -> None:
        refused = [job for job in gone.values() if not job.job_id]
        stillborn = [job for job in gone.values() if job.job_id and not job.came_up]
        if refused or stillborn:
            self._wait_s = min(max(FIRST_WAIT_S, 2 * self._wait_s), LONGEST_WAIT_S)
            self._not_before = time.monotonic() + self._wait_s
        again = f"next try in {self._wait_s:.0f} s"
        if refused:
            self._on_note(
                f"{self._jobs_scheduler.submit_command} failed for {len(refused)} jobs ({refused[0].error}); {again}"
            )
        if stillborn:
            log = self._run_folder / "logs" / f"worker-{stillborn[0].job_id}.log"
            self._on_note(f"{len(stillborn)} jobs ended before their worker came up, see {log}; {again}")
        lost = len(gone) - len(refused) - len(stillborn)
        if lost:
            self._on_note(f"{lost} workers ended, replaced by new jobs")

    def _judge(self, refusals: list[str]) -> None:
        """Give up hope when everything was refused for long and no job is left. `refusals`: new reasons."""
        if any(job.job_id for job in self.workers.values()):
            self._refused_since = None
        elif refusals and self._refused_since is None:
            self._refused_since = time.monotonic()
        elif refusals and self._refused_since is not None and time.monotonic() - self._refused_since > GIVE_UP_S:
            command, minutes = self._jobs_scheduler.submit_command, GIVE_UP_S / 60
            self.hopeless = f"{command} has refused every worker for {minutes:.0f} minutes ({refusals[-1]})"

    async def _cancel(self, ids: list[str]) -> None:
        if ids:
            try:
                await asyncio.to_thread(self._jobs_scheduler.cancel, ids)
            except SchedulerError as error:
                self._on_note(f"{len(ids)} jobs cannot be cancelled, they end by themselves: {error}")
