"""The command line. Every command is a few lines over the library.

Exit codes: 0 done, 1 failed, 2 bad input, 130 stopped: by Ctrl-C, SIGTERM or a closed terminal.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

try:
    import click

    from gaitflow.cli.bench import bench
    from gaitflow.cli.certify import certify
    from gaitflow.cli.check import status, validate, verify
    from gaitflow.cli.cluster import cancel, doctor, submit
    from gaitflow.cli.compact import compact
    from gaitflow.cli.datasets import datasets
    from gaitflow.cli.drive import drive
    from gaitflow.cli.estimate import estimate
    from gaitflow.cli.export import export
    from gaitflow.cli.init import init
    from gaitflow.cli.interrupt import while_running
    from gaitflow.cli.labels import labels
    from gaitflow.cli.models import models
    from gaitflow.cli.paper import paper
    from gaitflow.cli.plan import plan
    from gaitflow.cli.robot import robot
    from gaitflow.cli.show import show
    from gaitflow.cli.stages import atlas, label, publish, report, run, solve, train
    from gaitflow.cli.sweep import sweep
    from gaitflow.cli.trace import trace
    from gaitflow.cli.upload import upload
    from gaitflow.cli.walk import walk
    from gaitflow.pipeline.workspace import Workspace
except ImportError as error:
    sys.exit(f'gaitflow: the command line needs more than the runtime ({error}): pip install "gaitflow[maps]"')

COMMANDS = (
    init,
    run, solve, label, atlas, train, publish, report,  # a map's stages
    sweep,
    estimate, submit, cancel, doctor, compact,  # on a cluster
    plan, models, datasets, labels, show, trace, export, upload, walk, drive,  # what a map is for
    status, validate, verify, certify, robot, paper, bench,
)  # fmt: skip


class Interruptible(click.Group):
    """A group whose commands may be stopped, see `while_running`."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command that was given; a KeyboardInterrupt may say what was stopped, as `RunStopped` does."""
        with while_running():
            return super().invoke(ctx)


@click.group(cls=Interruptible, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="gaitflow")
@click.option(
    "--root",
    default=".",
    type=click.Path(path_type=Path),
    help="The workspace: its configs/ are searched before those that ship; runs/, datasets/ and models/ are in it.",
)
@click.pass_context
def main(context: click.Context, root: Path) -> None:
    """Find which gait a legged robot should use, and plan its motion.

    \b
    Example: gaitflow run quickstart
             gaitflow plan models/quickstart --speed 0.9 --cycle 0.6
    """
    if not root.is_dir():
        click.echo(f"gaitflow: --root {root}: no such folder; give the one with configs/", err=True)
        sys.exit(2)
    context.obj = Workspace(root)


for command in COMMANDS:
    main.add_command(command)
