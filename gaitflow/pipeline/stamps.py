"""What of a scenario each stage depends on, as files whose dates say which stages are out of date.

A part of the resolved scenario is an input file of its stage, written only when its content changes: a stage reruns
when what it uses changed, and not when a YAML file was only touched or got a new comment.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from gaitflow.config.scenario import Scenario
from gaitflow.files import atomic_write, make_folder
from gaitflow.pipeline.workspace import Run


def parts_of(scenario: Scenario) -> dict[str, Any]:
    """The parts by name: `problem`, which is solved, `ties`, by which is labelled, and `learning`."""
    data = scenario.as_data()
    learning = data.pop("learning")
    del data["description"], data["robot"]["source"]  # prose
    return {"problem": data, "ties": learning["tie_tolerance"], "learning": learning}


def stamp(run: Run, scenario: Scenario, part: str) -> Path:
    """The file of that part, brought up to date.

    A stage does this before its work, so that a result made by its command is newer than the part that it is of.
    Raises WriteError when the run's folder cannot be written.
    """
    content = (json.dumps(parts_of(scenario)[part], indent=1, sort_keys=True) + "\n").encode()
    path = run.folder / "stamps" / f"{part}.json"
    if not path.exists() or path.read_bytes() != content:
        make_folder(path.parent)
        atomic_write(path, content)
    return path
