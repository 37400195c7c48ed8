from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gaitflow.config.scenario import Tasks
from gaitflow.report.interactive_map import MAX_SLICES, interactive_map
from gaitflow.report.palette import gait_colours
from gaitflow.report.task_facts import RIVALS


@pytest.fixture(scope="module")
def data(scenario, labels, solutions, gaits, select) -> dict:
    return interactive_map(labels, solutions, scenario, gaits, select)


def test_every_task_is_there_with_its_gait_and_motion(data, labels) -> None:
    assert len(data["tasks"]) == len(labels)
    for task, row in zip(data["tasks"], labels.to_dict("records"), strict=True):
        assert (task["x"], task["y"]) == (row["speed"], row["cycle_duration"])
        assert task["held_out"] == (row["split"] == "held_out")
        assert (task["gait"], task["found"]) == (row["gait"], row["status"] == "solved")
        assert task["tied"] == (len(row["ties"]) > 1)
        if task["found"]:
            assert task["colour"] == gait_colours([row["gait"]])[row["gait"]] == task["motion"]["colours"]["stance"]
            assert task["motion"]["rows"] == row["pattern"].split("/")
            np.testing.assert_allclose(sum(task["motion"]["durations"]), row["cycle_duration"], atol=1e-3)
    (missing,) = [task for task in data["tasks"] if not task["found"]]
    assert missing["motion"] is None and missing["rivals"] == []
    assert dict(missing["facts"]) == {"split": "grid", "status": "infeasible"}


def test_it_starts_at_a_grid_task_of_the_gait_that_wins_most(data) -> None:
    first = data["tasks"][data["start"]]
    assert first["gait"] == "gallop" == data["gaits"][0]["name"] and not first["held_out"]
    assert 0.7 < first["x"] < 2.3 and 0.4 < first["y"] < 1.6


def test_a_task_tells_its_numbers(scenario, labels, solutions, gaits, select) -> None:
    judged = labels.assign(cost_error=4e-3, resolved=labels["speed"] > 1.0)
    tasks = interactive_map(judged, solutions, scenario, gaits, select)["tasks"]
    slow, fast = (next(task for task in tasks if (task["x"], task["y"]) == (v, 0.4)) for v in (0.1, 2.3))
    assert slow["title"] == "v = 0.1 m/s, T = 0.4 s"
    *told, (phases, durations) = slow["facts"]
    assert phases == "phases" and durations.endswith(" s")
    assert sum(map(float, durations[:-2].split(" + "))) == pytest.approx(0.4, abs=2e-3)
    assert dict(told) == {
        "split": "grid",
        "cost": "3,708",
        "margin": "0.04 %",
        "cost error": "0.4 %, not resolved",
        "gaits that tie": "walking, gallop-walk",
        "the map's choice": "walking",
        "pattern": "0111/1101",
    }
    assert dict(fast["facts"])["cost error"] == "0.4 %, resolved"


def test_rivals_are_the_other_gaits_by_cost(scenario, labels, solutions, gaits) -> None:
    best = next(one for one in solutions if one.status == "solved" and one.task.speed == 2.3)
    others = ["0111/1101", "0011/0110", "1100/0011", "1000/0100", "0110/0100", "0010/0110", "0010/0100", "0111/1110"]
    dearer = [
        replace(best, pattern=pattern, gait=pattern, cost=best.cost * (1.5 - 0.05 * place), trajectory=None)
        for place, pattern in enumerate([*others, "1110/0111"])
    ]
    tasks = interactive_map(labels, [best, *dearer], scenario, gaits, None)["tasks"]
    at = next(task for task in tasks if (task["x"], task["y"]) == (best.task.speed, best.task.cycle_duration))
    excesses = [excess for _, excess in at["rivals"]]
    assert len(excesses) == RIVALS and excesses[:2] == ["10 %", "15 %"]
    assert at["gait"] not in dict(at["rivals"])


def test_without_solves_only_the_runner_up_is_known(scenario, labels, gaits, select) -> None:
    data = interactive_map(labels, [], scenario, gaits, select)
    task = next(task for task in data["tasks"] if task["x"] == 0.1 and task["found"])
    assert task["rivals"] == [("gallop-walk", "0.04 %")] and task["motion"] is None
    assert data["robot"] is None


def test_regions_are_the_maps_choice(data, scenario, labels, solutions, gaits) -> None:
    (only,) = data["slices"]
    assert only["place"] == [] and data["sliders"] == []
    assert len(only["regions"]) == 6  # the rule never chooses gallop-pronk
    (bare,) = interactive_map(labels, solutions, scenario, gaits, None)["slices"]
    assert bare["regions"] == []


def test_further_axes_have_sliders_over_all_slices(sloped, sloped_labels, gaits) -> None:
    data = interactive_map(sloped_labels, [], sloped, gaits, None)
    (slider,) = data["sliders"]
    assert slider["label"] == "slope" and len(slider["values"]) == 12 and slider["values"][0] == "-22°"
    assert [one["place"] for one in data["slices"]] == [[i] for i in range(12)]
    grid = [task for task in data["tasks"] if not task["held_out"]]
    assert not any(task["between"] for task in grid) and {task["slice"] for task in grid} == set(range(12))
    (between,) = [task for task in data["tasks"] if task["between"]]
    assert data["sliders"][0]["values"][between["slice"]] == "2°"  # its slope is 1.7 degrees
    assert "open where they lie between slices, in the nearest one" in data["marks"]


def test_tasks_off_the_grid_stand_in_the_nearest_slice_of_two_sliders(turning, turning_labels, gaits) -> None:
    data = interactive_map(turning_labels, [], turning, gaits, None)
    assert [(slider["label"], len(slider["values"])) for slider in data["sliders"]] == [
        ("lateral speed", 5),
        ("yaw rate", 4),
    ]
    assert [one["place"] for one in data["slices"]] == [[i, j] for i in range(5) for j in range(4)]
    lateral, yaw = np.linspace(-0.4, 0.4, 5), np.linspace(-0.6, 0.6, 4)
    for task, row in zip(data["tasks"], turning_labels.to_dict("records"), strict=True):
        at = np.abs(lateral - row["lateral_speed"]).argmin(), np.abs(yaw - row["yaw_rate"]).argmin()
        assert data["slices"][task["slice"]]["place"] == list(at) and not task["between"]
    assert data["marks"][0] == "circles are searched tasks" and data["marks"][-1] == "each in the slice nearest to it"
    first = data["tasks"][data["start"]]
    assert not first["held_out"] and dict(first["facts"])["split"] == "searched"


def test_of_very_many_slices_an_even_part_is_shown_with_all_tasks(
    turning, turning_labels, gaits, turning_select
) -> None:
    axes = turning.tasks.as_data()["axes"]
    axes |= {axis: axes[axis] | {"count": 60} for axis in ("lateral_speed", "yaw_rate")}
    fine = turning.model_copy(update={"tasks": Tasks.from_data({"axes": axes, "sampling": "adaptive"}, "tasks")})
    data = interactive_map(turning_labels, [], fine, gaits, turning_select)
    assert [len(slider["values"]) for slider in data["sliders"]] == [15, 15] and len(data["slices"]) == MAX_SLICES
    assert len(data["tasks"]) == 360 and {task["slice"] for task in data["tasks"]} <= set(range(MAX_SLICES))
    assert all(len(one["regions"]) > 1 for one in data["slices"])


def test_a_map_of_one_axis_is_a_strip(scenario, labels, gaits) -> None:
    axes = {"speed": scenario.tasks.as_data()["axes"]["speed"], "cycle_duration": 0.8}
    strip = scenario.model_copy(update={"tasks": Tasks.from_data({"axes": axes}, "tasks")})
    row = labels[labels["cycle_duration"] == 0.8]
    data = interactive_map(row, [], strip, gaits, lambda values: np.zeros(len(values["speed"]), dtype=int))
    assert [axis["label"] for axis in data["axes"]] == ["speed v [m/s]"]
    assert [len(one["regions"]) for one in data["slices"]] == [1] and len(data["tasks"]) == 12
