"""A mirror image is a motion of the image's task at the same cost, and a run keeps it beside what it was made from."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.core import check
from gaitflow.core.gaits import Pattern
from gaitflow.core.task import Task
from gaitflow.dataset import load_solutions
from gaitflow.dataset.collect import collect, tasks_as_chosen
from gaitflow.dataset.mirror import START, MirrorImage, has_images, images_of
from gaitflow.problem import transcribe
from gaitflow.search import starts
from gaitflow.search.rows import solution, unsolved
from gaitflow.search.solution import Solution
from gaitflow.solvers.fixed_gait import FixedGaitSolver, Start
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import plan_cold

SCENARIO = Path(__file__).parents[2] / "configs/scenarios/anymal-omni.yaml"
WALK, TROT = "0011/1100/1110/1001", "0011/1100/1100/0011"


def scenario(**axes: Any) -> Scenario:
    """ANYmal in every direction on a coarse mesh."""
    whole = load_scenario(SCENARIO)
    tasks = whole.tasks.as_data()
    tasks["axes"] |= axes
    settings = whole.transcription.model_copy(update={"knots_per_phase": 4})
    return whole.model_copy(update={"tasks": whole.tasks.from_data(tasks, "omni"), "transcription": settings})


def task(split: str = "sampled", **values: float) -> Task:
    given = {"speed": 0.4, "lateral_speed": 0.2, "yaw_rate": 0.5, "cycle_duration": 0.6} | values
    return scenario().tasks.space.task(given, split)  # type: ignore[arg-type]


@cache
def solved(pattern: str) -> Solution:
    """A pattern solved where the body turns left while it drifts to the left."""
    one, problem = scenario(), transcribe(scenario())
    start = Start("nominal", starts.nominal(one.robot, problem.layout, task()))
    attempt = FixedGaitSolver(problem, 20.0).solve(Pattern.from_text(pattern), task(), start)
    assert attempt.feasible
    return solution(one, task(), Pattern.from_text(pattern), [attempt])


@pytest.mark.parametrize("pattern", [TROT, WALK])
def test_an_image_is_a_motion_of_its_task_at_the_same_cost(pattern: str) -> None:
    one, data = solved(pattern), scenario().as_data()
    image = MirrorImage(scenario()).of(one)
    assert image.task.on(("speed", "lateral_speed", "yaw_rate", "cycle_duration")) == (0.4, -0.2, -0.5, 0.6)
    assert image.trajectory is not None and one.trajectory is not None
    assert check.worst(data, image.trajectory, image.task, image.pattern) <= check.FEASIBLE
    costs = [check.cost(data, of.trajectory, of.task, of.pattern) for of in (one, image) if of.trajectory]
    assert costs[1] == pytest.approx(costs[0], rel=1e-12) and image.cost == one.cost
    wrong = check.worst(data, image.trajectory, one.task, image.pattern)
    assert wrong > 0.01, "it is no motion of the task that was searched"
    assert (image.start, image.solves, image.iterations, image.cpu_s, image.wall_s) == (START, 0, 0, 0.0, 0.0)


@pytest.mark.parametrize("pattern", [TROT, WALK])
def test_an_images_multipliers_are_those_of_its_optimum(pattern: str) -> None:
    one, problem = solved(pattern), transcribe(scenario())
    solver, spent = FixedGaitSolver(problem, 20.0), []
    for row in (one, MirrorImage(scenario()).of(one)):
        assert row.trajectory is not None and row.multipliers is not None
        w = problem.layout.pack(row.trajectory, row.task.cycle_duration)
        attempt = solver.solve(Pattern.from_text(row.pattern), row.task, Start("known", w, row.multipliers))
        assert attempt.feasible and attempt.cost == pytest.approx(one.cost, rel=1e-4)
        spent.append(attempt.iterations)
    assert spent[0] == spent[1]


def test_the_image_of_an_image_is_what_it_was_made_from() -> None:
    one, image = solved(WALK), MirrorImage(scenario())
    again = image.of(image.of(one))
    assert (again.task, again.pattern, again.gait) == (one.task, one.pattern, one.gait)
    assert again.trajectory is not None and one.trajectory is not None
    assert again.multipliers is not None and one.multipliers is not None
    for name in ("base", "feet", "forces", "end_forces", "foot_velocities", "durations"):
        np.testing.assert_array_equal(getattr(again.trajectory, name), getattr(one.trajectory, name))
    np.testing.assert_array_equal(again.multipliers.rows, one.multipliers.rows)
    np.testing.assert_array_equal(again.multipliers.bounds, one.multipliers.bounds)


def test_places_of_images_are_found_where_the_objective_is_energy() -> None:
    """There which leg stands in which phase is in the decision vector, too."""
    energy = load_scenario(SCENARIO.with_name("anymal-energy.yaml"))
    settings = energy.transcription.model_copy(update={"knots_per_phase": 3})
    one = energy.model_copy(update={"tasks": scenario().tasks, "transcription": settings})
    layout = transcribe(one).layout
    assert layout.energy
    for place, sign in MirrorImage(one).places:
        np.testing.assert_array_equal(place[place], np.arange(len(place)))  # the image of an image is what it was
        np.testing.assert_array_equal(sign * sign[place], np.ones(len(place)))
    variables, _ = MirrorImage(one).places
    left, right = (np.arange(layout.nw)[layout.contacts(leg)] for leg in (0, 1))
    np.testing.assert_array_equal(variables[0][left], right)


def test_a_gait_that_is_its_own_image_is_known_by_its_own_pattern() -> None:
    image = MirrorImage(scenario())
    trot, walk = image.known([solved(TROT), solved(WALK)])
    assert (trot.pattern, trot.trajectory, trot.cost) == (TROT, None, solved(TROT).cost)
    assert (walk.pattern, walk.trajectory) == (Pattern.from_text(WALK).mirrored((1, 0, 3, 2)).text, None)
    straight = replace(solved(TROT), task=task(lateral_speed=0.0, yaw_rate=0.0))
    assert not list(image.known([straight])), "its task is its own image"


def test_a_row_without_a_motion_has_an_image_without_one() -> None:
    row = unsolved(scenario(), task(), Pattern.from_text(WALK), "costs too much")
    image = MirrorImage(scenario()).of(row)
    assert (image.status, image.solver_status, image.trajectory) == ("screened", "costs too much", None)
    assert Pattern.from_text(image.pattern).mirrored((1, 0, 3, 2)).text == WALK and image.gait != row.gait


@pytest.mark.parametrize(
    ("axes", "known"),
    [
        ({}, True),
        ({"lateral_speed": {"start": -0.2, "stop": 0.4, "count": 3}}, False),
        ({"lateral_speed": 0.1}, False),
        ({"lateral_speed": 0.0, "yaw_rate": 0.0}, False),  # every task is its own image
        ({"lateral_speed": 0.0}, True),
    ],
)
def test_a_map_has_images_where_its_ranges_are_their_own(axes: dict[str, Any], known: bool) -> None:
    assert has_images(scenario(**axes)) is known


def test_a_robot_without_mirror_pairs_has_no_images() -> None:
    one = scenario()
    lame = one.model_copy(update={"robot": one.robot.model_copy(update={"mirror": ()})})
    assert not has_images(lame)


def test_tasks_that_are_their_own_images_have_none() -> None:
    straight = task(lateral_speed=0.0, yaw_rate=0.0)
    assert images_of([task(), straight]) == [task(lateral_speed=-0.2, yaw_rate=-0.5)]


def test_a_dataset_has_the_images_of_what_the_map_was_made_from(tmp_path: Path) -> None:
    one, store = scenario(), UnitStore(tmp_path)
    held_out = task(speed=0.7)
    for unit in plan_cold(one, [task(), held_out]):
        row = solved(WALK)
        store.write(unit, [row if unit.tasks == (task(),) else replace(row, task=held_out)], {})
    found = load_solutions(collect(store, one, [task(), held_out], [held_out]))
    assert [(row.task.speed, row.task["yaw_rate"], row.split, row.start) for row in found] == [
        (0.7, 0.5, "held_out", "nominal"), (0.4, -0.5, "sampled", START), (0.4, 0.5, "sampled", "nominal")
    ]  # fmt: skip
    image = MirrorImage(one).of(solved(WALK))
    assert image.trajectory is not None and found[1].base is not None
    np.testing.assert_array_equal(found[1].base, image.trajectory.base)
    assert tasks_as_chosen(found) == sorted([task(), replace(held_out, split="sampled")])
