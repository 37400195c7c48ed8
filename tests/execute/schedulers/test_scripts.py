"""The scripts that sbatch is given, to the letter (tests/data/sbatch/PROFILE.JOB.sh); the driver's, run in a shell."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from gaitflow.config.cluster import Profile, load_profile
from gaitflow.execute.schedulers.scripts import RESTARTS, doctor_script, driver_script, worker_script
from gaitflow.execute.schedulers.slurm import Slurm

PROFILES = Path(__file__).parents[3] / "slurm" / "profiles"
EXPECTED = Path(__file__).parents[2] / "data" / "sbatch"
NAMES = ("centre-48h", "preemptible", "test-cluster")
RUN = Path("/shared/project/runs/quickstart")
ROOT = Path("/shared/project")
PYTHON = "/shared/project/.venv/bin/python"
LEAST = {"name": "a", "walltime": "01:00:00", "jobs": 1}


def worker(profile: Profile, run: Path = RUN) -> str:
    return worker_script(Slurm(), profile, run, "4f1c2a-7", "tls://10.0.0.5:40001", 600.0, PYTHON)


def driver(profile: Profile, run: Path = RUN, root: Path = ROOT) -> str:
    return driver_script(
        Slurm(), profile, run, root, "quickstart", run / "cluster/profile.yaml", run / "cluster/driver.sh", PYTHON
    )


def doctor(profile: Profile, run: Path = RUN) -> str:
    return doctor_script(Slurm(), profile, run.parent / ".doctor-1", PYTHON)


JOBS: dict[str, Callable[[Profile], str]] = {"worker": worker, "driver": driver, "doctor": doctor}


@pytest.mark.parametrize("job", JOBS)
@pytest.mark.parametrize("name", NAMES)
def test_the_text_of_each_job_of_each_profile(name: str, job: str) -> None:
    text = JOBS[job](load_profile(PROFILES / f"{name}.yaml"))
    assert text == (EXPECTED / f"{name}.{job}.sh").read_text()
    subprocess.run(["bash", "-n"], input=text, text=True, check=True)


def test_no_expected_text_is_left_over() -> None:
    assert {file.name for file in EXPECTED.iterdir()} == {f"{name}.{job}.sh" for name in NAMES for job in JOBS}


@pytest.mark.parametrize("job", JOBS)
def test_slurm_reads_directives_only_before_the_first_command(job: str) -> None:
    lines = JOBS[job](load_profile(PROFILES / "centre-48h.yaml")).splitlines()
    first = next(i for i, line in enumerate(lines) if not line.startswith("#"))
    assert lines[0] == "#!/bin/bash"
    assert all(line.startswith("#SBATCH --") for line in lines[1:first])
    assert not [line for line in lines[first:] if line.startswith("#SBATCH")]


def test_odd_folders_are_quoted_for_sbatch_and_for_the_shell() -> None:
    text = worker(Profile.from_data(LEAST, "a"), Path('/shared/50% of "it" $HOME/runs/a'))
    assert '#SBATCH --output="/shared/50%% of \\"it\\" $HOME/runs/a/logs/worker-%j.log"' in text
    assert "--tls-key '/shared/50% of \"it\" $HOME/runs/a/tls/key.pem'" in text
    assert "cd '/shared/it is' || exit 1" in driver(Profile.from_data(LEAST, "a"), root=Path("/shared/it is"))


def test_a_folder_that_breaks_the_line_is_refused() -> None:
    for make in (worker, driver):
        with pytest.raises(ValueError, match="cannot be named in a script"):
            make(Profile.from_data(LEAST, "a"), Path("/shared/a\n#SBATCH --account=root/runs/a"))


def test_without_tls_no_key_is_named() -> None:
    assert "tls-key" not in worker(Profile.from_data(LEAST | {"tls": False}, "a"))


class Bench:
    """Runs the driver's script with stand-ins for Python and scontrol that write down what they are called with."""

    def __init__(self, folder: Path, behaviour: str) -> None:
        self.calls = folder / "calls"
        python, scontrol = folder / "python", folder / "scontrol"
        python.write_text(f'#!/bin/bash\necho "python $4 $5 $6" >> {self.calls}\n{behaviour}\n')
        scontrol.write_text(f'#!/bin/bash\necho "scontrol $*" >> {self.calls}\n')
        for program in (python, scontrol):
            program.chmod(0o755)
        profile, kept = Profile.from_data(LEAST, "a"), (folder / "p.yaml", folder / "driver.sh")
        text = driver_script(Slurm(), profile, folder / "run", folder, "s", *kept, str(python))
        self._script = folder / "driver.sh"
        self._script.write_text(text)
        self._environment = os.environ | {"PATH": f"{folder}:{os.environ['PATH']}", "SLURM_JOB_ID": "42"}

    def start(self, restarts: int = 0) -> subprocess.Popen[bytes]:
        environment = self._environment | {"SLURM_RESTART_COUNT": str(restarts)}
        return subprocess.Popen(["bash", str(self._script)], env=environment, stderr=subprocess.DEVNULL)

    def lines(self) -> list[str]:
        return self.calls.read_text().splitlines() if self.calls.exists() else []

    def wait_for(self, line: str) -> None:
        deadline = time.monotonic() + 20
        while line not in self.lines():
            assert time.monotonic() < deadline
            time.sleep(0.05)


STOPS_CLEANLY = 'trap "echo stopped >> $(dirname $0)/calls; exit 1" TERM; sleep 30 & wait'


def test_the_driver_solves_and_then_runs_the_other_stages(tmp_path: Path) -> None:
    bench = Bench(tmp_path, "exit 0")
    assert bench.start().wait(20) == 0
    root = str(tmp_path)
    assert bench.lines() == [f"python {root} solve s", f"python {root} run s"]


def test_a_driver_that_fails_says_so_and_does_not_come_back(tmp_path: Path) -> None:
    bench = Bench(tmp_path, "exit 1")
    assert bench.start().wait(20) == 1
    assert len(bench.lines()) == 1


@pytest.mark.parametrize(("restarts", "comes_back"), [(0, True), (RESTARTS - 1, True), (RESTARTS, False)])
def test_a_driver_that_is_killed_comes_back_but_not_for_ever(tmp_path: Path, restarts: int, comes_back: bool) -> None:
    bench = Bench(tmp_path, "kill -9 $$")
    assert bench.start(restarts).wait(20) == 128 + signal.SIGKILL
    assert ("scontrol requeue 42" in bench.lines()) == comes_back


@pytest.mark.parametrize(("number", "comes_back"), [(signal.SIGUSR1, True), (signal.SIGTERM, False)])
def test_signals_stop_the_driver_cleanly(tmp_path: Path, number: signal.Signals, comes_back: bool) -> None:
    bench = Bench(tmp_path, STOPS_CLEANLY)
    process = bench.start()
    bench.wait_for(f"python {tmp_path} solve s")
    time.sleep(0.3)  # its trap has to be set
    process.send_signal(number)
    assert process.wait(20) in (1, 128 + number)  # its own, or that of the signal: Slurm knows better than either
    expected = [f"python {tmp_path} solve s", "stopped"] + (["scontrol requeue 42"] if comes_back else [])
    assert bench.lines() == expected
