"""What makes a dataset again from its record alone: the scenario, its robot, and a workflow over them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import yaml

WORKFLOW = "Snakefile"


def remake_files(scenario: Mapping[str, Any]) -> dict[str, str]:
    """The files of a workspace, by name, in which `snakemake --cores 2` solves and labels the scenario's tasks again.

    `scenario` is its JSON data in today's form.
    """
    name, robot = scenario["name"], scenario["robot"]["name"]
    files = {f"configs/scenarios/{name}.yaml": _yaml(dict(scenario) | {"robot": robot})}
    files[f"configs/robots/{robot}.yaml"] = _yaml(scenario["robot"])
    return {WORKFLOW: _workflow(name, list(files)), **files}


def _yaml(data: Mapping[str, Any]) -> str:
    return yaml.safe_dump(dict(data), sort_keys=False, allow_unicode=True)


def _workflow(name: str, inputs: list[str]) -> str:
    needs = ", ".join(f'"{file}"' for file in inputs)
    return f"""# Solves and labels the scenario again, here: snakemake --cores 2
rule label:
    input: "runs/{name}/solutions.parquet"
    output: "runs/{name}/labels.parquet", "runs/{name}/gait_costs.parquet"
    shell: "gaitflow label {name}"

rule solve:
    input: {needs}
    output: "runs/{name}/solutions.parquet"
    threads: workflow.cores
    shell: "gaitflow solve {name} --workers {{threads}}"
"""
