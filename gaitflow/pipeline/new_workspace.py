"""The first files of a workspace: a scenario and its robot as they ship, a README of five commands, a .gitignore."""

from __future__ import annotations

from pathlib import Path

from gaitflow import shipped
from gaitflow.config.file import ConfigError
from gaitflow.files import publish_once

SCENARIO = "quickstart.yaml"
ROBOT = "half_cheetah.yaml"


def new_workspace(folder: Path) -> tuple[Path, ...]:
    """Write the first files into `folder`, which may exist, and return them.

    Raises ConfigError, and writes nothing, when one of them is there already; WriteError.
    """
    contents = {
        folder / "configs" / "scenarios" / SCENARIO: shipped.SCENARIOS / SCENARIO,
        folder / "configs" / "robots" / ROBOT: shipped.ROBOTS / ROBOT,
        folder / "README.md": shipped.WORKSPACE / "README.md",
        folder / ".gitignore": shipped.WORKSPACE / ".gitignore",
    }
    for file in contents:
        if file.exists():
            raise ConfigError(f"{file}: is there already, and init writes over nothing; name another folder")
    for file, source in contents.items():
        publish_once(file, source.read_bytes())
    return tuple(contents)
