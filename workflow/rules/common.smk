# What of a scenario each stage depends on: see gaitflow/pipeline/stamps.py.
import sys
from functools import cache
from pathlib import Path

from gaitflow.config.file import ConfigError
from gaitflow.pipeline.stamps import stamp
from gaitflow.pipeline.workspace import Workspace

WORKSPACE = Workspace(Path())


wildcard_constraints:
    scenario="[a-z0-9]+(-[a-z0-9]+)*",


# The `gaitflow` of the environment that runs Snakemake, whether or not that environment is activated.
shell.prefix(f'export PATH="{Path(sys.executable).parent}:$PATH"; ')


# Scenarios that are given by the path of their file, by their name.
FILES = config.get("files", {})


def named(wildcards):
    return FILES.get(wildcards.scenario, wildcards.scenario)


@cache
def scenario_of(name):
    try:
        return WORKSPACE.scenario(FILES.get(name, name))
    except ConfigError as error:
        raise WorkflowError(str(error)) from None


# At once: Snakemake takes a result whose inputs cannot be worked out for a source file, and says "nothing to do".
for name in config["scenarios"]:
    scenario_of(name)


def part(name):
    def file_of(wildcards):
        scenario = scenario_of(wildcards.scenario)
        return str(stamp(WORKSPACE.run(scenario), scenario, name))

    return file_of
