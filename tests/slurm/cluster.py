"""A real Slurm on this machine, for tests: munged, slurmctld and three slurmd on the loopback interface.

Everything of it lives below one folder. It needs Debian's packages slurm-wlm and munge, no root and no installation:

    python tests/slurm/cluster.py start /tmp/slurm     # ends when three nodes are idle
    eval "$(python tests/slurm/cluster.py env /tmp/slurm)"
    sinfo; sbatch job.sh; squeue
    python tests/slurm/cluster.py stop /tmp/slurm      # ends its daemons and jobs and deletes the folder

With `start --accounting`, `sacct` tells the CPU time of each job (tests/slurm/accounting.py).

Partition `work` is the default and preemptible (its jobs are requeued); a job in `urgent` takes their place. A job that
takes more memory than it asked for is killed.
"""

from __future__ import annotations

import argparse
import getpass
import os
import secrets
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path

import accounting

PROGRAMS = ("setsid", "munged", "slurmctld", "slurmd", "sbatch", "squeue", "sinfo", "scontrol", "scancel")
NODES = ("n1", "n2", "n3")
CPUS_PER_NODE = 4
MARK = "GAITFLOW_TEST_SLURM"  # in the environment of every daemon and job step: whose it is
NODE_MARK = "GAITFLOW_TEST_NODE"  # and of which node
OWNED = ".gaitflow-test-slurm"  # in every folder that `stop` may delete
READY_S = 30.0
POLL_S = 0.1
SOCKET_PATH_LIMIT = 107

CONF = """\
ClusterName=gaitflow
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort={controller_port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.sock,cred_expire=5
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool/%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=task=1
JobAcctGatherParams=OverMemoryKill
{storage}
JobCompType=jobcomp/filetxt
JobCompLoc={folder}/completed.log
MailProg=/bin/true
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
DefMemPerCPU=500
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=1,sched_min_interval=0,batch_sched_delay=0,bf_interval=1
KillWait=5
SlurmdTimeout=10
ReturnToService=1
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
{nodes}
PartitionName=work Nodes=n[1-3] Default=YES MaxTime=INFINITE State=UP PriorityTier=1
PartitionName=urgent Nodes=n[1-3] MaxTime=INFINITE State=UP PriorityTier=10
"""
NODE = "NodeName={name} NodeHostName=localhost NodeAddr=127.0.0.1 Port={port} CPUs={cpus} RealMemory=4000"


class ClusterError(RuntimeError):
    """The cluster cannot be started or stopped; the message says why and where to look."""


def missing_programs(programs: Sequence[str] = PROGRAMS) -> list[str]:
    """Which of these programs are not installed; by default Slurm's and munge's."""
    return [program for program in programs if program_path(program) is None]


class Cluster:
    """The Slurm below `folder`. Its state is its files and processes, so any process may take it up by its folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()
        self.conf = self.folder / "slurm.conf"

    def environment(self) -> dict[str, str]:
        """What a process has to have in its environment to use this cluster."""
        return {"SLURM_CONF": str(self.conf)}

    def start(self, until: int | None = None, with_accounting: bool = False) -> None:
        """Start all daemons in a new folder and wait until every node is idle. Raises ClusterError.

        When the process `until` ends, however it ends, so does the cluster.
        """
        if missing := missing_programs():
            raise ClusterError(f"{', '.join(missing)} not found: apt-get install slurm-wlm munge")
        if with_accounting and (missing := missing_programs(accounting.PROGRAMS)):
            raise ClusterError(f"{', '.join(missing)} not found: apt-get install slurmdbd mariadb-server")
        if len(f"{self.folder}/munge.sock") > SOCKET_PATH_LIMIT:
            raise ClusterError(f"{self.folder}: too long for a socket's path; choose a shorter folder")
        try:
            self.folder.mkdir(parents=True, mode=0o755)
        except FileExistsError:
            raise ClusterError(f"{self.folder} exists; choose a new folder, or stop the cluster in it") from None
        try:
            database_port, slurmdbd_port = self._configure(with_accounting)
            if until is not None:
                self._launch("keeper", sys.executable, __file__, "keep", str(self.folder), "--until", str(until))
            self._launch("munged", *self._munged())
            self._wait("munged", (self.folder / "munge.sock").exists)
            if with_accounting:
                self._launch("database", *accounting.database_command(self.folder, database_port))
                self._wait("database", lambda: _listens(database_port))
                self._launch("slurmdbd", "slurmdbd", "-D")
                self._wait("slurmdbd", lambda: _listens(slurmdbd_port))
            self.start_controller()
            for node in NODES:
                self.start_node(node)
            self._wait("slurmd", lambda: self.idle_nodes() == len(NODES))
        except BaseException:
            self.end_processes()
            raise

    def stop(self) -> None:
        """End every daemon and job of this cluster, however they fare, and delete its folder. Raises ClusterError."""
        if not (self.folder / OWNED).is_file():
            raise ClusterError(f"{self.folder}: no cluster was started there")
        self.end_processes()
        shutil.rmtree(self.folder)

    def keep(self, until: int) -> None:
        """Wait for the process `until` to end, then stop the cluster if it is still there."""
        while not _has_ended(until):
            time.sleep(POLL_S)
        if self.folder.exists():
            self.stop()

    def end_processes(self) -> None:
        """kill -9 all daemons and all jobs. Raises ClusterError."""
        self._kill_all(lambda: [*self.daemons(), *self.job_processes()])

    def start_controller(self) -> None:
        """Start slurmctld, with the state that an earlier one left."""
        self._launch("slurmctld", "slurmctld", "-D", "-i", "-f", str(self.conf))
        self._wait("slurmctld", lambda: self.call("scontrol", "ping", check=False).count("UP") > 0)

    def kill_controller(self) -> None:
        """kill -9 slurmctld."""
        self._kill_all(lambda: [pid for pid in self.daemons() if _runs(pid, "slurmctld")])

    def start_node(self, name: str) -> None:
        """Start the slurmd of a node."""
        self._launch(name, "slurmd", "-D", "-N", name, "-f", str(self.conf))

    def kill_node(self, name: str) -> None:
        """A node loses power: kill -9 its slurmd, its job steps, and all that runs in its jobs."""
        self._kill_all(lambda: [*self.daemons(name), *self.job_processes(name)])

    def set_node(self, name: str, state: str) -> None:
        """scontrol's view of a node: `down`, `resume`, `drain`."""
        self.call("scontrol", "update", f"nodename={name}", f"state={state}", "reason=test")

    def repair(self) -> None:
        """End all jobs, start what was killed, and wait until every node is idle. Raises ClusterError."""
        if not any(_runs(pid, "slurmctld") for pid in self.daemons()):
            self.start_controller()
        for node in NODES:
            if not any(_runs(pid, "slurmd") for pid in self.daemons(node)):
                self.start_node(node)
        self.call("scancel", "--user", getpass.getuser(), "--signal=KILL", check=False)
        self.call("scancel", "--user", getpass.getuser(), check=False)
        self._wait("slurmd", self._settled)

    def _settled(self) -> bool:
        for line in self.call("sinfo", "-h", "-N", "-p", "work", "-o", "%N %T", check=False).splitlines():
            node, state = line.split()
            if state.startswith(("down", "drain")):
                self.call("scontrol", "update", f"nodename={node}", "state=resume", check=False)
        return self.idle_nodes() == len(NODES) and not self.call("squeue", "-h", check=False)

    def completed(self) -> str:
        """Slurm's record of all jobs that have ended, a line each."""
        return (self.folder / "completed.log").read_text()

    def idle_nodes(self) -> int:
        """How many nodes are up and have no job."""
        return len(self.call("sinfo", "-h", "-N", "-p", "work", "-t", "idle", "-o", "%N", check=False).split())

    def call(self, *command: str, check: bool = True, timeout: float = 60.0) -> str:
        """The standard output of one of Slurm's commands. Raises ClusterError with what it said when it fails."""
        path = program_path(command[0]) or command[0]
        environment = os.environ | self.environment()
        done = subprocess.run(
            [path, *command[1:]], env=environment, capture_output=True, text=True, timeout=timeout, check=False
        )
        if check and done.returncode:
            raise ClusterError(f"{shlex.join(command)}: {done.stderr.strip() or done.stdout.strip()}")
        return done.stdout

    def daemons(self, node: str | None = None) -> list[int]:
        """Processes of munged, slurmctld, slurmd and of the job steps (`slurmstepd`); or those of one node."""
        marks = {f"{MARK}={self.folder}"} | ({f"{NODE_MARK}={node}"} if node else set())
        return [pid for pid in _processes() if marks <= set(_read(pid, "environ"))]

    def job_processes(self, node: str | None = None, job: str | None = None) -> list[int]:
        """What runs inside jobs: in all of them, on one node, in one job."""
        marks = {f"SLURM_CONF={self.conf}"} | ({f"SLURMD_NODENAME={node}"} if node else set())
        marks |= {f"SLURM_JOB_ID={job}"} if job else set()
        environments = ((pid, set(_read(pid, "environ"))) for pid in _processes())
        return [
            pid
            for pid, environment in environments
            if marks <= environment and any(name.startswith("SLURM_JOB_ID=") for name in environment)
        ]

    def _configure(self, with_accounting: bool) -> tuple[int, int]:
        """Write all configuration. Returns the ports of the database and of slurmdbd."""
        (self.folder / OWNED).touch()
        for name in ("state", "spool"):
            (self.folder / name).mkdir(mode=0o755)
        key = self.folder / "munge.key"
        key.touch(mode=0o600)
        key.write_bytes(secrets.token_bytes(1024))
        controller, database, slurmdbd, *ports = _free_ports(3 + len(NODES))
        nodes = (NODE.format(name=name, port=port, cpus=CPUS_PER_NODE) for name, port in zip(NODES, ports, strict=True))
        storage = "AccountingStorageType=accounting_storage/none"
        if with_accounting:
            accounting.configure(self.folder, slurmdbd, database)
            storage = accounting.STORAGE.format(port=slurmdbd, folder=self.folder)
        self.conf.write_text(
            CONF.format(
                controller_port=controller,
                user=getpass.getuser(),
                folder=self.folder,
                storage=storage,
                nodes="\n".join(nodes),
            )
        )
        return database, slurmdbd

    def _munged(self) -> list[str]:
        names = {"key-file": "munge.key", "socket": "munge.sock", "pid-file": "munged.pid", "seed-file": "munge.seed"}
        # --force: its own rules want a folder that all may enter, which pytest's are not.
        return ["munged", "--foreground", "--force", *(f"--{k}={self.folder / v}" for k, v in names.items())]

    def _launch(self, name: str, program: str, *arguments: str) -> None:
        marks = {MARK: str(self.folder)} | ({NODE_MARK: name} if name in NODES else {})
        with open(self.folder / f"{name}.log", "ab") as log:
            subprocess.run(
                [
                    "setsid",
                    "--fork",
                    program_path(program) or program,
                    *arguments,
                ],  # no child of ours: it may outlive us
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                cwd=self.folder,
                env=os.environ | self.environment() | marks,
                check=True,
            )

    def _kill_all(self, find: Callable[[], list[int]]) -> None:
        deadline = time.monotonic() + READY_S
        while left := find():  # again, for those that were just being started
            if time.monotonic() > deadline:
                raise ClusterError(f"{self.folder}: processes {left} cannot be killed")
            for pid in left:
                with suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            time.sleep(POLL_S)

    def _wait(self, name: str, ready: Callable[[], bool]) -> None:
        deadline = time.monotonic() + READY_S
        while not ready():
            if time.monotonic() > deadline:
                logs = "".join(
                    f"\n{log.name}: {line}"
                    for log in sorted(self.folder.glob("*.log"))
                    for line in log.read_text(errors="replace").splitlines()[-5:]
                )
                raise ClusterError(f"{name} is not ready after {READY_S:.0f} s{logs}")
            time.sleep(POLL_S)


def program_path(program: str) -> str | None:
    """Where a program is, if it is installed."""
    return shutil.which(program, path=f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin")  # where users have no sbin


def _free_ports(count: int) -> list[int]:
    with ExitStack() as stack:  # all held at once, so that no two are the same
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in sockets]


def _listens(port: int) -> bool:
    """Whether a program answers at this port of the loopback interface."""
    with suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=1.0):
        return True
    return False


def _processes() -> list[int]:
    """Everyone alive but ourselves."""
    pids = (int(path.name) for path in Path("/proc").glob("[0-9]*"))
    return [pid for pid in pids if pid != os.getpid() and not _has_ended(pid)]


def _has_ended(pid: int) -> bool:
    """Whether a process is gone; a zombie only waits for its parent to notice."""
    try:
        return Path(f"/proc/{pid}/stat").read_text(errors="replace").rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


def _read(pid: int, name: str) -> list[str]:
    try:
        return Path(f"/proc/{pid}/{name}").read_text(errors="replace").split("\0")
    except OSError:  # it ended, or is another user's
        return []


def _runs(pid: int, program: str) -> bool:
    return _read(pid, "comm")[0].strip() in (program, "slurmscriptd" if program == "slurmctld" else program)


def main(arguments: Sequence[str] | None = None) -> None:
    """The command line; see the module's text."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("action", choices=("start", "stop", "env", "keep"), metavar="start|stop|env")
    parser.add_argument("folder", type=Path, help="the cluster's own folder; `start` makes it, `stop` deletes it")
    parser.add_argument("--until", type=int, metavar="PID", help="with start: stop when this process has ended")
    parser.add_argument("--accounting", action="store_true", help="with start: keep accounts that `sacct` reads")
    options = parser.parse_args(arguments)
    cluster = Cluster(options.folder)
    try:
        match options.action:
            case "start":
                cluster.start(options.until, options.accounting)
            case "stop":
                cluster.stop()
            case "keep":
                cluster.keep(options.until)
            case _:
                for name, value in cluster.environment().items():
                    print(f"export {name}={shlex.quote(value)}")
    except ClusterError as error:
        sys.exit(f"{parser.prog}: {error}")


if __name__ == "__main__":
    main()
