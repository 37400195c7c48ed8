"""An export compiled as a library plans in Python's process as Python does; needs cmake, cc and g++."""

from __future__ import annotations

import shutil
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cpp_program import built
from tiny_map import TinyMap, write_map

from gaitflow.core.errors import ArtifactError
from gaitflow.export import Exported
from gaitflow.runtime import GaitMap, Plan
from gaitflow.runtime import attempt as attempt_module
from gaitflow.runtime.refine import Refiner

pytestmark = pytest.mark.slow


def library(export: Path, build: Path) -> Path:
    built(export, build, "gaitflow_planner", source=export)
    return build


@pytest.fixture(scope="module")
def compiled(exported: Exported, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder where the export of the small real map was built."""
    return library(exported.folder, tmp_path_factory.mktemp("library"))


def tasks_of(gait_map: GaitMap, count: int) -> list[dict[str, float]]:
    """Random tasks of the domain."""
    random, domain = np.random.default_rng(3), gait_map.manifest.domain
    ends = [(values[0], values[-1]) for values in domain.axes.values()]
    tasks = [dict(zip(gait_map.axes, random.uniform(*np.transpose(ends)).tolist(), strict=True)) for _ in range(count)]
    return [task for task in tasks if domain.contains(task)]


def same(one: Plan, other: Plan) -> bool:
    found = [(plan.gait, plan.pattern, plan.path, [name for name, _ in plan.tried]) for plan in (one, other)]
    return found[0] == found[1] and abs(one.cost / other.cost - 1) < 1e-6


def test_plans_are_those_of_python(exported: Exported, compiled: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    by_python, fast = GaitMap.load(exported.model), GaitMap.load(exported.model, compiled=compiled)
    tasks = tasks_of(by_python, 200)
    forced = by_python.gaits[-1].name
    expected = [by_python.plan(**task) for task in tasks]
    own = [by_python.plan(**task, gait=forced) for task in tasks[:20]]
    monkeypatch.setattr(Refiner, "fast", None)  # compiled code made these
    planned = [fast.plan(**task) for task in tasks]
    assert len(planned) > 100
    assert [plan.gait for plan, other in zip(planned, expected, strict=True) if not same(plan, other)] == []
    assert all(plan.feasible and plan.violation <= 1e-6 for plan in planned), "by our own check"
    assert all(same(fast.plan(**task, gait=forced), plan) for task, plan in zip(tasks[:20], own, strict=True))


def test_each_thread_has_matrices_of_its_own(exported: Exported, compiled: Path) -> None:
    fast = GaitMap.load(exported.model, compiled=compiled)
    tasks = tasks_of(fast, 60)
    alone, together = [fast.plan(**task).cost for task in tasks], {}

    def plan(number: int) -> None:
        together[number] = [fast.plan(**task).cost for task in tasks]

    threads = [threading.Thread(target=plan, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(costs == alone for costs in together.values()) and len(together) == 4


def test_a_motion_that_our_check_refuses_is_solved_by_python(
    exported: Exported, compiled: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fast, verdicts = GaitMap.load(exported.model, compiled=compiled), [1.0]
    worst = attempt_module.check.worst
    task = tasks_of(fast, 1)[0]

    def refused(*arguments: Any) -> float:
        return verdicts.pop() if verdicts else worst(*arguments)

    monkeypatch.setattr(attempt_module.check, "worst", refused)
    plan = fast.plan(**task)
    assert plan.feasible and not verdicts and same(plan, GaitMap.load(exported.model).plan(**task))


def test_a_library_of_another_map_is_refused(exported: Exported, compiled: Path, tiny: TinyMap, tmp_path: Path) -> None:
    other = write_map(replace(tiny, solver_options=tiny.solver_options | {"max_iter": 201}), tmp_path / "quickstart")
    with pytest.raises(ArtifactError, match="was built from another map than"):
        GaitMap.load(other, compiled=compiled)


def test_what_is_no_library_is_one_line(exported: Exported, compiled: Path, tmp_path: Path) -> None:
    with pytest.raises(ArtifactError, match=r"gaitflow_planner\.so: is not there; build the folder that `gaitflow"):
        GaitMap.load(exported.model, compiled=exported.folder)
    damaged = tmp_path / "damaged"
    shutil.copytree(compiled, damaged)
    with (damaged / "map.bin").open("r+b") as file:
        file.seek(1000)
        file.write(b"\xff\xff")
    with pytest.raises(ArtifactError, match=r"map\.bin: its checksum is wrong: .*; export the map again and build it"):
        GaitMap.load(exported.model, compiled=damaged)
    (tmp_path / "gaitflow_planner.so").write_text("no code")
    with pytest.raises(ArtifactError, match="is no planner of this machine"):
        GaitMap.load(exported.model, compiled=tmp_path)
