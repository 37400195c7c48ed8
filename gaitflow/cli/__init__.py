"""The command line, `gaitflow` or `python -m gaitflow.cli`."""

from gaitflow.cli.interrupt import while_importing

with while_importing():
    from gaitflow.cli.main import main

__all__ = ["main"]
