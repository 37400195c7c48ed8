"""How a command ends: exit codes 0 done, 1 failed, 2 bad input; one clear line on standard error, data on output.

Ctrl-C is another end, see `interrupt`.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

import click

from gaitflow.config.file import ConfigError
from gaitflow.config.scenario import Scenario
from gaitflow.pipeline.earlier import StageMissing


def print_json(data: Any) -> None:
    """One JSON document on standard output."""
    click.echo(json.dumps(data, indent=1, allow_nan=False))


def fail(message: str) -> NoReturn:
    """Say why on standard error and leave with exit code 1."""
    click.echo(f"gaitflow: {message}", err=True)
    sys.exit(1)


def warn_of_training(scenario: Scenario) -> None:
    """Say on standard error what `gaitflow train` will need and does not find here, before hours are spent solving."""
    from gaitflow.learn.installed import what_lacks

    if lacking := what_lacks(scenario.learning):
        click.echo(f"gaitflow: {scenario.name} can be solved here, but not trained: {lacking}", err=True)


@contextmanager
def refused_artifact(trusting: str = "") -> Iterator[None]:
    """A map that cannot be used is bad input; one that needs its code to be trusted names the command's option."""
    from gaitflow.runtime import ArtifactError

    try:
        yield
    except ArtifactError as error:
        hint = f"; here: {trusting}" if trusting and "trust_code" in str(error) else ""
        raise ConfigError(f"{error}{hint}") from None


@contextmanager
def bad_input() -> Iterator[None]:
    """One clear line and exit code 2 for what the user gave us, 1 for a stage that is missing or a full disk."""
    try:
        yield
    except (StageMissing, OSError) as error:
        fail(str(error))
    except (ConfigError, ValueError) as error:
        click.echo(f"gaitflow: {error}", err=True)
        sys.exit(2)
