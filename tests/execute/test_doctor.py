"""The doctor with a Slurm that is played: `sbatch` runs the job's script here, as a process of its own."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import pytest

from gaitflow.config.cluster import Profile
from gaitflow.execute import doctor, doctor_node
from gaitflow.execute.doctor import Finding, examine

SBATCH = """\
#!/bin/bash
[ "$1" = --version ] && echo "slurm 99.1" && exit 0
cat > {folder}/job.sh
log=$(sed -n 's/^#SBATCH --output=//p' {folder}/job.sh)
SLURM_JOB_ID=7 setsid bash {folder}/job.sh > "$log" 2>&1 < /dev/null &
echo 7
"""
SINFO = "#!/bin/bash\necho 'work|work*|up|1:00:00|3'\n"
CHECKS = [
    *("sbatch", "partition of the workers", "partition of the driver"),
    *("job", "shared folder", "atomic link", "clock", "Python", "scratch"),
]


@pytest.fixture(autouse=True)
def slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "bin"
    folder.mkdir()
    for name, text in {
        "sbatch": SBATCH.format(folder=folder),
        "sinfo": SINFO,
        "squeue": "#!/bin/bash\n",
        "scancel": f'#!/bin/bash\necho "$*" >> {folder}/cancelled\n',
    }.items():
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}:/usr/bin:/bin")
    return folder


def found(tmp_path: Path, wait_s: float = 60.0, **fields: Any) -> dict[str, Finding]:
    driver = {"walltime": "00:30:00"}
    profile = Profile.from_data({"name": "a", "walltime": "00:30:00", "jobs": 1, "driver": driver} | fields, "a.yaml")
    findings = {finding.check: finding for finding in examine(profile, tmp_path / "runs", wait_s)}
    assert not list((tmp_path / "runs").glob(".doctor-*")), "nothing is left behind"
    return findings


def test_a_sound_cluster(tmp_path: Path, slurm: Path) -> None:
    findings = found(tmp_path, interface="lo")
    assert list(findings) == [*CHECKS, "interface"]
    assert all(finding.ok for finding in findings.values())
    assert findings["sbatch"].text == "slurm 99.1"
    assert (slurm / "cancelled").read_text() == "--quiet 7\n"


def test_without_slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    (finding,) = found(tmp_path).values()
    assert not finding.ok and "run this where Slurm is" in finding.text


def test_a_walltime_that_the_partition_does_not_allow(tmp_path: Path) -> None:
    findings = found(tmp_path, walltime="02:00:00")
    assert list(findings) == CHECKS[:3]
    assert findings["partition of the workers"].text == "work allows 3600 s, the walltime is 7200 s; shorten it"
    assert findings["partition of the driver"].ok


def test_a_partition_that_does_not_exist(tmp_path: Path, slurm: Path) -> None:
    (slurm / "sinfo").write_text("#!/bin/bash\n")
    assert "long: no such partition" in found(tmp_path, partition="long")["partition of the workers"].text


def test_a_job_that_sbatch_refuses(tmp_path: Path, slurm: Path) -> None:
    (slurm / "sbatch").write_text(
        "#!/bin/bash\n[ $1 = --version ] && exit\necho 'sbatch: error: Invalid account' >&2\nexit 1\n"
    )
    findings = found(tmp_path)
    assert not findings["job"].ok and findings["job"].text.startswith("sbatch: Invalid account; check account")


def test_a_node_that_cannot_load_us_says_what_it_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "SETTLE_S", 2.0)
    finding = found(tmp_path, setup=["export PYTHONHOME=/nowhere"])["job"]
    assert not finding.ok and "ended without a report; it said: " in finding.text and "Python" in finding.text


def test_a_job_that_never_starts(tmp_path: Path, slurm: Path) -> None:
    (slurm / "squeue").write_text(
        f'#!/bin/bash\necho "7|PENDING|gaitflow-doctor|$(cat {slurm}/mark)|QOSMaxJobsPerUserLimit"\n'
    )
    (slurm / "sbatch").write_text(
        f"#!/bin/bash\n[ $1 = --version ] && exit\nsed -n 's/^#SBATCH --comment=//p' > {slurm}/mark\necho 7\n"
    )
    finding = found(tmp_path, wait_s=1.0)["job"]
    assert "job 7 is pending (QOSMaxJobsPerUserLimit) after 1 s" in finding.text
    assert (slurm / "cancelled").read_text() == "--quiet 7\n"


def test_a_file_system_whose_links_are_not_atomic(tmp_path: Path) -> None:
    finding = found(tmp_path, setup=[f"rm {tmp_path}/runs/.doctor-*/{doctor_node.TAKEN}"])["atomic link"]
    assert not finding.ok and "a unit could be stored twice" in finding.text


def test_clocks_that_disagree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = time.time
    monkeypatch.setattr(doctor.time, "time", lambda: real() + 100)
    finding = found(tmp_path)["clock"]
    assert not finding.ok and "100 s apart" in finding.text


def test_another_version_on_the_node(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    here = doctor_node.environment()
    monkeypatch.setattr(doctor_node, "environment", lambda: here | {"gaitflow": "0.0.1"})
    finding = found(tmp_path)["Python"]
    assert not finding.ok and "here; use one" in finding.text and "0.0.1" in finding.text


def test_scratch_and_interface_of_the_node(tmp_path: Path) -> None:
    findings = found(tmp_path, scratch="/proc/nowhere", interface="ib9")
    assert not findings["scratch"].ok and "/proc/nowhere" in findings["scratch"].text
    assert not findings["interface"].ok and "no such interface, but lo" in findings["interface"].text
