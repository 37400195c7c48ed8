"""The whole workflow by one `gaitflow submit`: the map of a coarse quickstart is the one that this machine makes."""

from __future__ import annotations

import json
import shutil
import time
from pathlib import Path

import pandas as pd
import pytest
import yaml
from cluster import Cluster
from command import gaitflow

from gaitflow.store.journal import read_journal

pytestmark = [pytest.mark.slurm, pytest.mark.slow, pytest.mark.timeout(900)]

ENDS_WITHIN_S = 600.0


def workspace(root: Path, checkout: Path) -> Path:
    shutil.copytree(checkout / "configs", root / "configs")
    file = root / "configs" / "scenarios" / "quickstart.yaml"
    data = yaml.safe_load(file.read_text())
    data["transcription"]["knots_per_phase"] = 3
    file.write_text(yaml.safe_dump(data))
    return root


def test_submitted_once_it_gives_the_same_labels_as_locally(cluster: Cluster, checkout: Path, tmp_path: Path) -> None:
    here, there = workspace(tmp_path / "here", checkout), workspace(tmp_path / "there", checkout)
    profile = checkout / "slurm" / "profiles" / "test-cluster.yaml"
    job = json.loads(gaitflow(there, "submit", "quickstart", "--profile", profile, "--json"))["job"]
    deadline, run = time.monotonic() + ENDS_WITHIN_S, there / "runs" / "quickstart"
    while f"JobId={job} " not in cluster.completed():
        assert time.monotonic() < deadline, "it did not end"
        time.sleep(0.5)
    log = (run / "logs" / f"driver-{job}.log").read_text()
    assert "JobState=COMPLETED" in cluster.completed().partition(f"JobId={job} ")[2].splitlines()[0], log
    state = json.loads(gaitflow(there, "status", "quickstart", "--json"))
    assert (state["left"], state["failed"], state["solved"]) == (0, 0, state["units"])
    gaitflow(here, "solve", "quickstart", "--workers", "2")
    gaitflow(here, "label", "quickstart")
    ours, theirs = (pd.read_parquet(root / "runs" / "quickstart" / "labels.parquet") for root in (there, here))
    pd.testing.assert_frame_equal(ours, theirs, rtol=1e-9)
    assert (ours["status"] == "solved").sum() > 20
    starts = [entry.unit for entry in read_journal(run / "journal") if entry.event == "start"]
    assert len(starts) == len(set(starts)), "a unit was solved more than once"
    assert list((there / "models" / "quickstart").iterdir()) and list((run / "report").glob("*.html"))
    assert cluster.call("squeue", "-h") == ""
