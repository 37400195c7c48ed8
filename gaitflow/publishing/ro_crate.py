"""A dataset as a Workflow Run Crate: what was run on which input, what came out, by which code on which machine."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from gaitflow.publishing import citation
from gaitflow.publishing.dataset_facts import DatasetFacts, Table
from gaitflow.publishing.remake import WORKFLOW, remake_files

FILE = "ro-crate-metadata.json"
_PROFILES = {
    "https://w3id.org/ro/wfrun/process/0.5": "Process Run Crate",
    "https://w3id.org/ro/wfrun/workflow/0.5": "Workflow Run Crate",
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0": "Workflow RO-Crate",
}
_CRATE = "https://w3id.org/ro/crate/1.1"
_SNAKEMAKE = "https://w3id.org/workflowhub/workflow-ro-crate#snakemake"
_AGENT, _CODE, _RUN = "#maintainers", "#gaitflow", "#run"

Entity = dict[str, Any]


def ro_crate(facts: DatasetFacts, described: Mapping[str, str]) -> str:
    """The JSON-LD document; `described` are further files of the crate, each with what it is."""
    inputs = [name for name in remake_files(facts.scenario) if name != WORKFLOW]
    tables = [_ref(table.file) for table in facts.tables]
    parts = [_ref(WORKFLOW), *map(_ref, inputs), *tables, *map(_ref, described)]
    graph = [
        _descriptor(),
        _root(facts, parts),
        _workflow(),
        {
            "@id": _SNAKEMAKE,
            "@type": "ComputerLanguage",
            "name": "Snakemake",
            "identifier": _ref("https://snakemake.github.io"),
            "url": _ref("https://snakemake.github.io"),
        },
        *(_input(name) for name in inputs),
        *(_output(table) for table in facts.tables),
        *({"@id": name, "@type": "File", "name": name, "description": what} for name, what in described.items()),
        _run(facts, inputs, tables),
        *_makers(facts),
        {"@id": _AGENT, "@type": "Organization", "name": citation.MAINTAINERS},
        {"@id": citation.LICENCE_ADDRESS, "@type": "CreativeWork", "name": citation.LICENCE},
        *({"@id": address, "@type": "CreativeWork", "name": name, "version": _version(address)}
          for address, name in _PROFILES.items()),
    ]  # fmt: skip
    return json.dumps({"@context": _context(), "@graph": graph}, indent=1, ensure_ascii=False) + "\n"


def _context() -> list[Any]:
    return [f"{_CRATE}/context", {"sha256": "https://w3id.org/ro/terms/workflow-run#sha256"}]


def _descriptor() -> Entity:
    conforms = [_CRATE, "https://w3id.org/workflowhub/workflow-ro-crate/1.0"]
    return {"@id": FILE, "@type": "CreativeWork", "about": _ref("./"), "conformsTo": [_ref(one) for one in conforms]}


def _root(facts: DatasetFacts, parts: list[Entity]) -> Entity:
    return {
        "@id": "./",
        "@type": "Dataset",
        "name": f"{facts.name} {facts.version}",
        "description": facts.scenario["description"] or f"Solved gaits and labels of {facts.name}.",
        "version": facts.version,
        "datePublished": facts.created,
        "license": _ref(citation.LICENCE_ADDRESS),
        "author": _ref(_AGENT),
        "publisher": _ref(_AGENT),
        "creditText": citation.PAPER,
        "conformsTo": [_ref(address) for address in _PROFILES],
        "mainEntity": _ref(WORKFLOW),
        "mentions": _ref(_RUN),
        "hasPart": parts,
    }


def _workflow() -> Entity:
    return {
        "@id": WORKFLOW,
        "@type": ["File", "SoftwareSourceCode", "ComputationalWorkflow"],
        "name": "solve and label every task of the scenario",
        "programmingLanguage": _ref(_SNAKEMAKE),
    }


def _input(name: str) -> Entity:
    what = "the robot" if "robots" in name else "the scenario: robot, objective, transcription, tasks, search"
    return {"@id": name, "@type": "File", "name": name, "description": what, "encodingFormat": "application/yaml"}


def _output(table: Table) -> Entity:
    return {
        "@id": table.file,
        "@type": "File",
        "name": table.file,
        "description": f"A row: {table.row}.",
        "encodingFormat": "application/vnd.apache.parquet",
        "contentSize": str(table.entry.bytes),
        "sha256": table.entry.sha256,
    }


def _run(facts: DatasetFacts, inputs: list[str], tables: list[Entity]) -> Entity:
    return {
        "@id": _RUN,
        "@type": "CreateAction",
        "name": f"solved and labelled {facts.tasks} tasks in {facts.record['units']} units of work",
        "instrument": _ref(WORKFLOW),
        "object": [*map(_ref, inputs), *(_ref(one["@id"]) for one in _makers(facts))],
        "result": tables,
        "agent": _ref(_AGENT),
        "endTime": facts.record["created"],
        "actionStatus": "http://schema.org/CompletedActionStatus",
    }


def _makers(facts: DatasetFacts) -> list[Entity]:
    """The software that solved, one for each commit and machine."""
    found = []
    for number, maker in enumerate(facts.record["made_by"]):
        code, packages = maker["code"], ", ".join(f"{name} {version}" for name, version in maker["packages"].items())
        changed = ", with uncommitted changes" if code.get("dirty") else ""
        found.append({
            "@id": f"{_CODE}-{number}",
            "@type": "SoftwareApplication",
            "name": "gaitflow",
            "version": code["version"],
            "softwareVersion": f"commit {code.get('commit', 'unknown')}{changed}",
            "softwareRequirements": f"Python {maker['python']}, {packages}",
            "processorRequirements": maker["cpu"],
            "operatingSystem": maker["system"],
        })  # fmt: skip
    return found


def _version(address: str) -> str:
    return address.rsplit("/", 1)[1]


def _ref(name: str) -> Entity:
    return {"@id": name}
