"""A dataset's record says which of its makers each unit of work had."""

from __future__ import annotations

from pathlib import Path

from gaitflow.config.scenario import load_scenario
from gaitflow.tables.provenance import dataset_record, processor_name


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


def test_generations_of_one_processor_name_differ() -> None:
    def cpuinfo(family: int, model: int) -> str:
        one = f"cpu family\t: {family}\nmodel\t\t: {model}\nmodel name\t: AMD EPYC\nstepping\t: 1"
        return f"processor\t: 0\n{one}\n\nprocessor\t: 1\n{one}\n\n"

    assert processor_name(cpuinfo(25, 1)) == "AMD EPYC (family 25, model 1)"
    assert processor_name(cpuinfo(26, 2)) == "AMD EPYC (family 26, model 2)"


def test_a_processor_is_named_as_far_as_cpuinfo_says() -> None:
    assert processor_name("model name\t: Cortex-A72\nBogoMIPS\t: 108.00\n") == "Cortex-A72"
    assert processor_name("processor\t: 0\nCPU part\t: 0xd08\n") == ""
    assert processor_name("") == ""
