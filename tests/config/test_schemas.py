"""The committed JSON Schemas are those of the models, and say what the models say."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml

from gaitflow.config.file import ConfigError
from gaitflow.config.robot import Robot, load_robot
from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.config.schemas import PUBLISHED_SCENARIO, file_schemas, published_scenario, write_schemas
from gaitflow.config.sweep import Sweep, load_sweep
from gaitflow.runtime.json_schema import fault_of

CONFIGS = Path(__file__).parents[2] / "configs"
COMMITTED = Path(__file__).parents[2] / "workflow" / "schemas"
SCENARIO, ROBOT, SWEEP = "scenario.schema.json", "robot.schema.json", "sweep.schema.json"
FILES = [
    (schema, path)
    for schema, folder in ((ROBOT, "robots"), (SCENARIO, "scenarios"), (SWEEP, "sweeps"))
    for path in sorted((CONFIGS / folder).glob("*.yaml"))
]


def load(path: Path) -> Any:
    return yaml.safe_load(path.read_text(encoding="utf-8"))


def validator(name: str) -> jsonschema.Draft202012Validator:
    schema = json.loads((COMMITTED / name).read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def test_the_committed_schemas_are_current(tmp_path: Path) -> None:
    written = {path.name: path.read_bytes() for path in write_schemas(tmp_path)}
    committed = {path.name: path.read_bytes() for path in COMMITTED.glob("*.json")}
    assert committed == written, "run: python -m gaitflow.config.schemas workflow/schemas"


def test_the_runtimes_schema_is_current_and_says_nothing_that_it_does_not_read() -> None:
    assert PUBLISHED_SCENARIO.read_bytes() == published_scenario(), (
        "run: python -m gaitflow.config.schemas workflow/schemas"
    )
    for path in sorted((CONFIGS / "scenarios").glob("*.yaml")):
        data = load_scenario(path).as_data()
        schema = json.loads(published_scenario())
        assert fault_of(data, schema) is None
        jsonschema.Draft202012Validator(schema).validate(data)


def test_the_module_writes_the_schemas(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "gaitflow.config.schemas"]
    done = subprocess.run([*command, str(tmp_path)], capture_output=True, text=True, check=True)
    assert sorted(done.stdout.split()) == sorted(str(path) for path in tmp_path.iterdir())
    unused = subprocess.run(command, capture_output=True, text=True, check=False)
    assert unused.returncode == 1
    assert unused.stderr.startswith("usage:")


@pytest.mark.parametrize(("schema", "path"), FILES, ids=lambda value: getattr(value, "stem", value))
def test_every_configuration_is_valid(schema: str, path: Path) -> None:
    validator(schema).validate(load(path))


def test_every_field_and_every_definition_is_there() -> None:
    schemas = file_schemas()
    assert list(schemas[SCENARIO]["properties"]) == list(Scenario.model_fields)
    assert list(schemas[ROBOT]["properties"]) == list(Robot.model_fields)
    assert list(schemas[SWEEP]["properties"]) == list(Sweep.model_fields)
    for schema in schemas.values():
        text = json.dumps(schema)
        assert all(f'"#/$defs/{name}"' in text for name in schema["$defs"]), "a definition that nothing refers to"


BROKEN: list[tuple[str, str, Any]] = [
    (ROBOT, "mass", -14.0),
    (ROBOT, "dimension", 4),
    (ROBOT, "legs", []),
    (ROBOT, "weight", 14.0),
    (ROBOT, "name", "Half Cheetah"),
    (SCENARIO, "robot", {"name": "half_cheetah"}),
    (SCENARIO, "robot", "../robots/half_cheetah"),
    (SCENARIO, "strategy", {"name": "genetic"}),
    (SCENARIO, "stances_per_leg", 2),
    (SCENARIO, "terrain", {"slope_deg": 90}),
    (SCENARIO, "tasks", None),
    (SCENARIO, "colour", "red"),
    (SWEEP, "samples", 0),
    (SWEEP, "ranges", {}),
    (SWEEP, "ranges", {"mass": [1.0]}),
    (SWEEP, "ranges", {"mass": {"factor": [0.5, 2.0], "step": 0.1}}),
    (SWEEP, "robot", "half_cheetah"),
]


@pytest.mark.parametrize(("name", "field", "value"), BROKEN)
def test_schema_and_model_refuse_the_same(name: str, field: str, value: Any, tmp_path: Path) -> None:
    good, read = {
        ROBOT: ("robots/half_cheetah.yaml", load_robot),
        SCENARIO: ("scenarios/quickstart.yaml", lambda path: load_scenario(path, robots=CONFIGS / "robots")),
        SWEEP: ("sweeps/half-cheetah.yaml", load_sweep),
    }[name]
    data = load(CONFIGS / good) | {field: value}
    path = tmp_path / Path(good).name
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    errors = list(validator(name).iter_errors(data))
    assert len(errors) == 1
    assert field in f"{errors[0].json_path} {errors[0].message}"
    with pytest.raises(ConfigError, match=field):
        read(path)
