"""`gaitflow run` in front of Snakemake: the stage graph of workflow/ for one scenario."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from gaitflow.config.file import ConfigError
from gaitflow.pipeline.workspace import Workspace

PROFILE = "GAITFLOW_PROFILE"  # tells `gaitflow solve`: as an argument of its rule it would make a finished solve rerun


def run_workflow(
    workspace: Workspace, scenario: str, workers: int, dry_run: bool, profile_file: Path | None = None
) -> bool:
    """Run what is out of date; True when everything asked for is done. Raises ConfigError without a workflow folder.

    With a profile the workers of the solve stage are jobs of a Slurm cluster.
    """
    snakefile = Path("workflow", "Snakefile")
    if not (workspace.root / snakefile).is_file():
        raise ConfigError(
            f"{workspace.root / snakefile}: no such file; `gaitflow run` belongs into a checkout, elsewhere give the "
            "stages one by one: solve, label, atlas, train, publish, report"
        )
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(snakefile), "--cores", str(workers)]
    command += ["--config", f"scenarios=['{scenario}']", "--rerun-incomplete", "--quiet", "progress", "host", "reason"]
    command.append("--dry-run" if dry_run else "rules")  # the stages speak for themselves
    # A stopped run leaves a lock behind; the store has its own rules for two writers, so it may be lifted.
    command.append("--nolock")
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    if profile_file is not None:
        environment[PROFILE] = str(profile_file.resolve())
    return subprocess.run(command, cwd=workspace.root, env=environment).returncode == 0
