"""The command line, `gaitflow` or `python -m gaitflow.cli`."""

import os

from gaitflow.cli.interrupt import while_importing
from gaitflow.execute.line_process import ONE_THREAD

# Before numpy is loaded, and although Snakemake asks for as many threads as a stage has cores: on more threads matrices
# are decomposed to other last digits, and what is solved from them differs. Work is shared among processes.
os.environ.update(ONE_THREAD)

with while_importing():
    from gaitflow.cli.main import main

__all__ = ["main"]
