# What of a scenario each stage depends on. Each stage has its part of the resolved scenario as an input file,
# runs/{scenario}/stamps/{part}.json, written only when its content changes: a stage reruns when what it uses
# changed, whoever made its last result, and not when a YAML file was only touched or got a new comment.
import json
import sys
from functools import cache
from pathlib import Path

from gaitflow.config.file import ConfigError
from gaitflow.pipeline.workspace import Workspace


wildcard_constraints:
    scenario="[a-z0-9]+(-[a-z0-9]+)*",


# The `gaitflow` of the environment that runs Snakemake, whether or not that environment is activated.
shell.prefix(f'export PATH="{Path(sys.executable).parent}:$PATH"; ')


# Scenarios that are given by the path of their file, by their name.
FILES = config.get("files", {})


def named(wildcards):
    return FILES.get(wildcards.scenario, wildcards.scenario)


@cache
def parts_of(name):
    try:
        data = Workspace(Path()).scenario(FILES.get(name, name)).as_data()
    except ConfigError as error:
        raise WorkflowError(str(error)) from None
    learning = data.pop("learning")
    del data["description"], data["robot"]["source"]  # prose
    return {"problem": data, "ties": learning["tie_tolerance"], "learning": learning}


# At once: Snakemake takes a result whose inputs cannot be worked out for a source file, and says "nothing to do".
for name in config["scenarios"]:
    parts_of(name)


def part(name):
    def stamp(wildcards):
        text = json.dumps(parts_of(wildcards.scenario)[name], indent=1, sort_keys=True) + "\n"
        path = Path(f"runs/{wildcards.scenario}/stamps/{name}.json")
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            fresh = path.with_suffix(".tmp")
            fresh.write_text(text, encoding="utf-8")
            fresh.replace(path)
        return str(path)

    return stamp
