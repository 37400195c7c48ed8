"""The command line, `gaitflow` or `python -m gaitflow.cli`."""

from gaitflow.cli.main import main

__all__ = ["main"]
