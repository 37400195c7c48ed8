"""`gaitflow run` in front of Snakemake: the stage graph that ships, for one scenario."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

from gaitflow import shipped
from gaitflow.config.scenario import Scenario
from gaitflow.files import make_folder
from gaitflow.pipeline.stoppable import run_stoppable
from gaitflow.pipeline.workspace import Workspace, from_anywhere

PROFILE = "GAITFLOW_PROFILE"  # tells `gaitflow solve`: as an argument of its rule it would make a finished solve rerun


def run_workflow(
    workspace: Workspace,
    scenario: Scenario,
    named: str,
    workers: int,
    dry_run: bool,
    profile_file: Path | None = None,
) -> bool:
    """Run what is out of date of `scenario`, which the user `named` so; True when everything asked for is done.

    With a profile the workers of the solve stage are jobs of a cluster. Raises WriteError when nothing can be
    written in the workspace.
    """
    make_folder(workspace.root)
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(shipped.SNAKEFILE), "--cores", str(workers)]
    files = json.dumps({scenario.name: from_anywhere(named)})
    command += ["--config", f"scenarios=['{scenario.name}']", f"files={files}"]
    # A scenario's parts are inputs of their stages, so nothing else says what is out of date.
    command += ["--rerun-incomplete", "--rerun-triggers", "mtime", "input"]
    command += ["--quiet", "progress", "host", "reason"]
    command.append("--dry-run" if dry_run else "rules")  # the stages speak for themselves
    # A stopped run leaves a lock behind; the store has its own rules for two writers, so it may be lifted.
    command.append("--nolock")
    environment = dict(os.environ)
    if profile_file is not None:
        environment[PROFILE] = str(profile_file.resolve())
    return run_stoppable(command, workspace.root, environment) == 0
