"""The C++ planner gives Python's plans; needs cmake, cc and g++."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cpp_program import SANITIZED, built, lines, run
from tiny_map import TinyMap, write_map

from gaitflow.core import check
from gaitflow.export import Exported, export_c
from gaitflow.runtime import GaitMap
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.rivals import EVEN, UNLIKELY
from gaitflow.runtime.versions import resolve

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def program(exported: Exported, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example built with the problem that all maps here have."""
    return built(exported.folder, tmp_path_factory.mktemp("build"), "plan")


@pytest.fixture(scope="module")
def export_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[TinyMap], Exported]:
    def made(tiny: TinyMap) -> Exported:
        folder = tmp_path_factory.mktemp("made")
        return export_c(write_map(tiny, folder / "quickstart"), folder / "c")

    return made


def tasks_of(gait_map: GaitMap, count: int) -> list[tuple[float, ...]]:
    """Random tasks of the domain."""
    random, domain = np.random.default_rng(0), gait_map.manifest.domain
    ends = np.transpose([(values[0], values[-1]) for values in domain.axes.values()])
    tasks = (tuple(random.uniform(*ends).tolist()) for _ in range(2 * count))
    return [task for task in tasks if domain.contains(dict(zip(gait_map.axes, task, strict=True)))][:count]


def planned(program: Path, export: Exported, tasks: list[tuple[float, ...]]) -> list[dict[str, Any]]:
    done = run(program, export.folder / "map.bin", lines(tasks))
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


@pytest.mark.parametrize(("which", "count"), [("exported", 300), ("crowded_export", 200)])
def test_the_example_plans_as_python_does(
    program: Path, which: str, count: int, request: pytest.FixtureRequest
) -> None:
    export: Exported = request.getfixturevalue(which)
    gait_map = GaitMap.load(export.model)
    tasks, layout = tasks_of(gait_map, count), gait_map.manifest.layout
    apart, own, paths, by_ipopt, chances = [], [], set(), 0, 0
    for task, answer in zip(tasks, planned(program, export, tasks), strict=True):
        values = dict(zip(gait_map.axes, task, strict=True))
        plan = gait_map.plan(**values)
        assert answer["in_domain"]
        if any("fallback" in outcome for _, outcome in plan.tried):
            assert not answer["refined"] and answer["path"] == "failed"
            by_ipopt += 1
            continue
        assert (answer["gait"], answer["pattern"], answer["path"]) == (plan.gait, plan.pattern, plan.path), task
        if answer["cost"] != pytest.approx(plan.cost, rel=1e-6):
            nudged = gait_map.plan(**values | {"speed": np.nextafter(values["speed"], np.inf)})
            assert answer["cost"] == pytest.approx(nudged.cost, rel=1e-6), "as Python's when the last bit is another"
            chances += 1
        assert answer["refined"] and answer["violation"] <= 1e-6
        paths.add(plan.path)
        motion = layout.unpack(np.array(answer["primal"]), values["cycle_duration"])
        primal = layout.pack(plan, values["cycle_duration"])
        apart.append(np.abs(primal - answer["primal"]).max())
        if len(own) < 100:
            nearest = gait_map.plan(**values | {"speed": np.nextafter(values["speed"], np.inf)})
            own.append(np.abs(layout.pack(nearest, values["cycle_duration"]) - primal).max())
        np.testing.assert_allclose(answer["durations"], motion.durations, rtol=1e-12)
        np.testing.assert_allclose(answer["feet"], motion.feet.ravel(), rtol=1e-12, atol=1e-15)
        asked = gait_map.manifest.space.task(values)
        assert check.worst(gait_map.manifest.scenario, motion, asked, plan.pattern) <= check.FEASIBLE
    assert by_ipopt <= 0.05 * count and chances <= 0.01 * count
    for share in (0.5, 0.9):
        largest = max(1e-6, 10 * np.quantile(own, share))
        assert np.quantile(apart, share) < largest, "as near as Python is to itself when the speed's last bit changes"
    assert which == "exported" or any(path != "fast" for path in paths), paths


def test_over_many_axes_it_starts_and_tries_what_python_does(wide_export: Exported, tmp_path: Path) -> None:
    """From the nominal start, as the atlas' points are random numbers; and both gaits, but an unlikely one."""
    gait_map, tried = GaitMap.load(wide_export.model), set()
    tasks = tasks_of(gait_map, 30)
    answers = planned(built(wide_export.folder, tmp_path, "plan"), wide_export, tasks)
    for task, answer in zip(tasks, answers, strict=True):
        plan = gait_map.plan(**dict(zip(gait_map.axes, task, strict=True)))
        assert (answer["gait"], answer["pattern"], answer["path"]) == (plan.gait, plan.pattern, plan.path), task
        assert plan.path != "fallback" and answer["refined"]
        assert answer["cost"] == pytest.approx(plan.cost, rel=1e-6)
        tried.add(len({gait for gait, _ in plan.tried}))
        assert answer["iterations"] == pytest.approx(plan.iterations, abs=2)
    assert tried == {1, 2}


def test_over_three_axes_a_published_map_tries_what_python_does(checkout: Path, tmp_path: Path) -> None:
    export = export_c(resolve(checkout / "models/anymal-slopes"), tmp_path / "c")
    gait_map, unlikely = GaitMap.load(export.model), 0
    tasks = tasks_of(gait_map, 24)
    answers = planned(built(export.folder, tmp_path, "plan"), export, tasks)
    for task, answer in zip(tasks, answers, strict=True):
        values = dict(zip(gait_map.axes, task, strict=True))
        plan, chances = gait_map.plan(**values), dict(gait_map.select(**values).ranked)
        assert (answer["gait"], answer["pattern"], answer["path"]) == (plan.gait, plan.pattern, plan.path), task
        assert answer["iterations"] == pytest.approx(plan.iterations, abs=2), "the same gaits are tried"
        assert all(chances[gait] >= UNLIKELY for gait, _ in plan.tried[1:])
        unlikely += sum(chance < UNLIKELY for chance in chances.values())
    assert unlikely


def test_over_two_axes_the_likeliest_gait_is_tried_as_python_does(checkout: Path, tmp_path: Path) -> None:
    export, others = export_c(resolve(checkout / "models/half-cheetah-exact-effort"), tmp_path / "c"), 0
    gait_map = GaitMap.load(export.model)
    chosen = {task: gait_map.select(*task) for task in tasks_of(gait_map, 400)}
    likeliest = {task: max(choice.ranked, key=lambda each: each[1]) for task, choice in chosen.items()}
    tasks = [task for task, (gait, chance) in likeliest.items() if chance >= EVEN and gait != chosen[task].gait]
    assert len(tasks) >= 10
    answers = planned(built(export.folder, tmp_path, "plan"), export, tasks)
    for task, answer in zip(tasks, answers, strict=True):
        plan = gait_map.plan(*task)
        assert likeliest[task][0] in {gait for gait, _ in plan.tried}
        assert (answer["gait"], answer["pattern"], answer["path"]) == (plan.gait, plan.pattern, plan.path), task
        others += answer["iterations"] != pytest.approx(plan.iterations, abs=2)
    assert others <= 0.05 * len(tasks), "as hard, but where the last bit decides how a solve goes"


def test_what_the_atlas_does_not_know_is_planned_from_the_mean(
    program: Path, tiny: TinyMap, export_of: Callable[[TinyMap], Exported]
) -> None:
    export = export_of(replace(tiny, atlas=Atlas.empty(tiny.atlas.axes)))
    gait_map = GaitMap.load(export.model)
    tasks = tasks_of(gait_map, 30)
    for task, answer in zip(tasks, planned(program, export, tasks), strict=True):
        plan = gait_map.plan(*task)
        if not any("fallback" in outcome for _, outcome in plan.tried):
            assert (answer["gait"], answer["path"]) == (plan.gait, plan.path)
            assert answer["cost"] == pytest.approx(plan.cost, rel=1e-6)


def test_what_does_not_converge_says_so(program: Path, tiny: TinyMap, export_of: Callable[[TinyMap], Exported]) -> None:
    lost = tuple(replace(start, primal=np.full_like(start.primal, 50.0)) for start in tiny.starts)
    export = export_of(replace(tiny, atlas=Atlas.empty(tiny.atlas.axes), starts=lost))
    answers = planned(program, export, [(0.9, 0.6), (99.0, 0.6)])
    assert answers[0]["path"] == "failed" and not answers[0]["refined"] and answers[0]["violation"] > 1e-6
    assert answers[1] == {"in_domain": False, "speed": 99.0, "cycle_duration": 0.6}


def test_it_touches_no_foreign_memory(crowded_export: Exported, tmp_path: Path) -> None:
    guarded = built(crowded_export.folder, tmp_path, "plan", f"{SANITIZED}address,undefined")
    tasks = tasks_of(GaitMap.load(crowded_export.model), 15)
    assert all(answer["refined"] for answer in planned(guarded, crowded_export, tasks))


def test_threads_share_a_map(crowded_export: Exported, tmp_path: Path) -> None:
    source = Path(__file__).parent / "threads"
    program = built(crowded_export.folder, tmp_path, "threads", f"{SANITIZED}thread", source)
    tasks = tasks_of(GaitMap.load(crowded_export.model), 20)
    done = run(program, crowded_export.folder / "map.bin", lines(tasks))
    assert (done.returncode, done.stdout) == (0, "80 of 80\n"), done.stderr
