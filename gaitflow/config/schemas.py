"""JSON Schemas of the configuration files, for editors and the workflow; the pydantic models are their source.

`python -m gaitflow.config.schemas workflow/schemas` writes them again after a model has changed, and that of the whole
scenario in a published map beside the runtime, which checks it by that. A schema holds what a field alone must be; how
fields must agree (phases that fit into a cycle, the shape of an inertia) only the models check.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from pydantic.json_schema import GenerateJsonSchema

import gaitflow
from gaitflow.config.cluster import Profile
from gaitflow.config.file import Config
from gaitflow.config.robot import Robot
from gaitflow.config.scenario import Scenario
from gaitflow.config.sweep import Sweep
from gaitflow.files import atomic_write

PUBLISHED_SCENARIO = Path(gaitflow.__file__).parent / "runtime" / "scenario.schema.json"


class _Untitled(GenerateJsonSchema):
    """Without a title for each field, which would only repeat its name."""

    def field_title_should_be_set(self, schema: Any) -> bool:
        return False


def _schema(model: type[Config]) -> dict[str, Any]:
    return {"$schema": _Untitled.schema_dialect, **model.model_json_schema(schema_generator=_Untitled)}


def file_schemas() -> dict[str, dict[str, Any]]:
    """Schema by file name: of a robot, a cluster's profile, a sweep, and of a scenario, which names its robot."""
    robot, scenario = _schema(Robot), _schema(Scenario)
    scenario["properties"]["robot"] = {
        "description": "Name of a file in the folder of robots, without its ending.",
        **robot["properties"]["name"],
    }
    for definition in ("Robot", *robot["$defs"]):
        del scenario["$defs"][definition]
    return {
        "profile.schema.json": _schema(Profile),
        "robot.schema.json": robot,
        "scenario.schema.json": scenario,
        "sweep.schema.json": _schema(Sweep),
    }


def write_schemas(folder: Path) -> tuple[Path, ...]:
    """Write every schema into the folder and return the files. Raises WriteError."""
    written = []
    for name, schema in file_schemas().items():
        path = folder / name
        atomic_write(path, _json(schema))
        written.append(path)
    return tuple(written)


def published_scenario() -> bytes:
    """The schema of a scenario as manifests hold it, with its robot: the content of PUBLISHED_SCENARIO."""
    return _json(_schema(Scenario))


def _json(schema: dict[str, Any]) -> bytes:
    return (json.dumps(schema, indent=2) + "\n").encode()


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m gaitflow.config.schemas FOLDER, such as workflow/schemas")
    for file in write_schemas(Path(sys.argv[1])):
        print(file)
    atomic_write(PUBLISHED_SCENARIO, published_scenario())
