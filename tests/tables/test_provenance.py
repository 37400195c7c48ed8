"""A dataset's record says which of its makers each unit of work had."""

from __future__ import annotations

from pathlib import Path

from gaitflow.config.scenario import load_scenario
from gaitflow.tables.provenance import dataset_record


def test_each_unit_names_its_maker_when_there_are_several(checkout: Path) -> None:
    scenario = load_scenario(checkout / "configs/scenarios/quickstart.yaml")
    parts = [
        {"made_by": {"cpu": "newer"}, "solver_options": {"tol": 1e-8}},
        {"made_by": {"cpu": "elder"}, "solver_options": {"tol": 1e-8}},
        {"made_by": {"cpu": "newer"}, "solver_options": {"tol": 1e-9}},
    ]
    record = dataset_record(scenario, ["a", "b", "c", "d"], parts, [1, 0, 2, 1])
    assert [record["made_by"][number]["cpu"] for number in record["units_made_by"]] == [
        "elder",
        "newer",
        "newer",
        "elder",
    ]
    assert "units_made_by" not in dataset_record(scenario, ["a", "b"], parts[:1], [0, 0])
