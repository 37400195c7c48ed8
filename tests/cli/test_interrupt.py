"""Ctrl-C in a real terminal, at several moments of real commands; and signals without a terminal."""

from __future__ import annotations

import os
import pty
import re
import select
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from gaitflow.store.journal import read_journal

LINE = "gaitflow: stopped; the same command goes on"
RUN_LINE = r"gaitflow: stopped: \d of 2 units are stored in .*; run the same command again to go on"
STOPPED = (130, -signal.SIGINT)  # the interpreter may end itself by the signal, which a shell calls 130, too
SMALL = """\
name: small
robot: half_cheetah
objective: {force: 1.0}
transcription: {integrator: momentum, forces: linear, grading: 1.0}
tasks:
  axes: {speed: {start: 0.1, stop: 1.1, count: 6}, cycle_duration: {start: 0.4, stop: 0.8, count: 2}}
  held_out: 0
learning: {methods: [knn]}
"""


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    (tmp_path / "small.yaml").write_text(SMALL)
    return tmp_path


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "gaitflow.cli", *arguments]


def in_terminal(workspace: Path, *arguments: str, press: Callable[[str, float], bool]) -> tuple[int, str]:
    """Exit code and output of a command on a terminal of its own, whose user presses Ctrl-C once.

    `press` says when, given what is on the screen and for how many seconds the command has run.
    """
    child, terminal = pty.fork()
    if child == 0:
        os.chdir(workspace)
        os.environ.pop("COVERAGE_PROCESS_CONFIG", None)  # Ctrl-C would meet coverage while it starts, not gaitflow
        # Nor is Ctrl-C to meet Python while it starts, on a slow machine: it waits for our first line.
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        os.execv(sys.executable, command(*arguments))
    screen, start, pressed = "", time.monotonic(), False
    while time.monotonic() - start < 60:
        if select.select([terminal], [], [], 0.02)[0]:
            try:
                screen += os.read(terminal, 1 << 16).decode(errors="replace")
            except OSError:  # nobody has the other end any more
                break
        if not pressed and press(screen, time.monotonic() - start):
            os.write(terminal, b"\x03")
            pressed = True
    else:
        os.kill(child, signal.SIGKILL)
    os.close(terminal)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), screen


def processes_in(folder: Path) -> list[str]:
    """Commands of the processes that work in a folder, or were started there for it."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            where, words = os.readlink(process / "cwd"), (process / "cmdline").read_bytes()
        except OSError:
            continue
        if words and where == str(folder):
            found.append(words.replace(b"\0", b" ").decode(errors="replace"))
    return found


def check(folder: Path, code: int, said: str, line: str) -> None:
    lines = [each for each in re.split(r"[\r\n]+", re.sub(r"\x1b\[[?0-9;]*[A-Za-z]", "", said)) if each]
    ours = [each for each in lines if "gaitflow: " in each]
    assert len(ours) == 1 and re.fullmatch(rf"(\^C)*{line}", ours[0]), said
    assert lines[-1] == ours[0], "nothing comes after it"
    assert "Traceback" not in said and "Error" not in said and "ignored" not in said, said
    assert code in STOPPED
    deadline = time.monotonic() + 5
    while processes_in(folder):
        assert time.monotonic() < deadline, processes_in(folder)
        time.sleep(0.05)


@pytest.mark.parametrize("library", ["os", "multiprocessing"])
def test_an_interrupt_that_a_finaliser_loses_is_one_line_too(library: str) -> None:
    lost = f"""
import os, signal, time, {library}
from gaitflow.cli.interrupt import while_running
class Dying:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0)
with while_running():
    Dying()
    time.sleep(30)
"""
    run = subprocess.run([sys.executable, "-c", lost], capture_output=True, text=True, timeout=20)
    assert (run.returncode, run.stderr) == (130, LINE + "\n")


@pytest.mark.parametrize("started_as", ["-m", "/usr/bin/gaitflow", "script.py", ""])
def test_ctrl_c_between_the_import_and_the_command_is_one_line(started_as: str) -> None:
    script = f"""
import os, signal, sys
sys.argv[0] = {started_as!r}
import gaitflow.cli
os.kill(os.getpid(), signal.SIGINT)
"""
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    if started_as in ("script.py", ""):  # whoever imports the command line keeps Python's own handler
        assert run.stderr.endswith("KeyboardInterrupt\n")
    else:
        assert (run.returncode, run.stderr) == (130, LINE + "\n")


def test_a_worker_that_imports_the_command_line_leaves_ctrl_c_blocked(tmp_path: Path) -> None:
    """Also in the threads of a library that is imported: they inherit what was blocked when they were started."""
    script = """
import multiprocessing, signal
from multiprocessing import resource_tracker
from gaitflow.cli.interrupt import while_importing
with while_importing():
    blocked = signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, [])
def look(answers):
    answers.send(blocked)
if __name__ == "__main__":
    spawn = multiprocessing.get_context("spawn")
    ours, theirs = spawn.Pipe()
    resource_tracker.ensure_running()
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    spawn.Process(target=look, args=(theirs,)).start()
    print(blocked, ours.recv())
"""
    (tmp_path / "script.py").write_text(script)
    run = subprocess.run(
        [sys.executable, tmp_path / "script.py"], capture_output=True, text=True, timeout=60, check=True
    )
    assert run.stdout == "False True\n"


@pytest.mark.parametrize("seconds", [0.5, 1.0])
@pytest.mark.parametrize("stage", ["run", "solve", "estimate"])
def test_ctrl_c_while_a_command_starts(workspace: Path, stage: str, seconds: float) -> None:
    """Whatever is interrupted then: imports, reading the scenario, or Snakemake's own start."""
    code, said = in_terminal(workspace, stage, "small.yaml", press=lambda screen, ran: ran > seconds)
    check(workspace, code, said, f"({LINE}|{RUN_LINE})")


@pytest.mark.slow
@pytest.mark.parametrize("stage", ["solve", "run"])
def test_ctrl_c_amid_solves_and_the_same_command_goes_on(workspace: Path, stage: str) -> None:
    unfinished = workspace / "runs" / "small" / "unfinished"
    code, said = in_terminal(workspace, stage, "small.yaml", press=lambda screen, ran: any(unfinished.glob("*/*")))
    check(workspace, code, said, RUN_LINE if stage == "solve" else LINE)
    assert re.search(r"[1-9]\d* of about \d+ solves", said), "solves are told before a unit is done"
    status = subprocess.run(command("status", "small.yaml"), cwd=workspace, capture_output=True, text=True, check=True)
    assert "driver: none" in status.stdout
    done = subprocess.run(command("solve", "small.yaml"), cwd=workspace, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "2 units solved, 0 given up" in done.stdout, done.stderr
    stored = [entry for entry in read_journal(workspace / "runs" / "small" / "journal") if entry.event == "stored"]
    assert sum(entry.known for entry in stored) >= 2 and not any(unfinished.iterdir())


@pytest.mark.slow
def test_ctrl_c_in_every_later_stage(workspace: Path) -> None:
    for stage in ("solve", "label", "atlas", "train", "publish", "report"):
        subprocess.run(command(stage, "small.yaml"), cwd=workspace, capture_output=True, check=True)
    last_words = {"label": "failed", "atlas": " MB", "train": "picks of the map", "publish": "datasets/small"}
    for stage in ("label", "atlas", "train", "publish", "report"):
        for seconds in (0.4, 1.5):
            if stage == "publish":  # otherwise it finds its version and has nothing to do
                shutil.rmtree(workspace / "models", ignore_errors=True)
            code, said = in_terminal(
                workspace, stage, "small.yaml", press=lambda screen, ran, seconds=seconds: ran > seconds
            )
            if last_words.get(stage, "index.html") in said:  # it was done
                assert "Traceback" not in said and code in (0, *STOPPED)
            else:
                check(workspace, code, said, LINE)
        subprocess.run(command(stage, "small.yaml"), cwd=workspace, capture_output=True, check=True)


def test_a_signal_that_is_to_be_ignored_stays_ignored() -> None:
    script = """
import os, signal
from gaitflow.cli.interrupt import while_running
signal.signal(signal.SIGHUP, signal.SIG_IGN)
with while_running():
    os.kill(os.getpid(), signal.SIGHUP)
    print("goes on")
assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
"""
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=20)
    assert (run.returncode, run.stdout, run.stderr) == (0, "goes on\n", "")


def test_without_a_terminal_the_whole_group_is_interrupted(workspace: Path) -> None:
    run = subprocess.Popen(
        command("run", "small.yaml"),
        cwd=workspace,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    time.sleep(3.0)
    os.killpg(run.pid, signal.SIGINT)
    said, _ = run.communicate(timeout=60)
    check(workspace, run.returncode, said, LINE)
    assert "\x1b[?25h" not in said
