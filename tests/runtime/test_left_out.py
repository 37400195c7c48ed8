"""The value of least cost on an axis that is left out, among those that the map allows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gaitflow.core.domain import Domain
from gaitflow.runtime import GaitMap, OutOfDomain
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.left_out import Chooser, ChosenValue, Per, left_out


class Bowl(Atlas):
    """Two gaits whose cost a second are parabolas in the duration, raised by the speed."""

    def costs_of_many(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        speed, duration = places.T
        rates = np.stack([1.0 + (duration - 0.73) ** 2, 1.02 + (duration - 1.1) ** 2]) + speed
        return (rates * duration).T, np.stack([np.ones(len(places)), np.where(duration < 1.3, 1.0, 0.5)], axis=1)


class Sheet:
    def __init__(self, gait: int) -> None:
        self.gait = gait


@pytest.fixture
def bowl() -> Atlas:
    return Bowl(("speed", "cycle_duration"), np.ones(2), 1e-4, (Sheet(0), Sheet(1)))  # type: ignore[arg-type]


def domain(feasible: list[bool] | None = None) -> Domain:
    values = (0.4, 0.6, 0.8, 1.0, 1.2, 1.4)
    column = np.array([True] * 6 if feasible is None else feasible)
    return Domain({"speed": (0.0, 1.0), "cycle_duration": values}, np.stack([column, column]))


def cheapest(
    atlas: Atlas,
    within: Domain,
    task: dict[str, float],
    scale: float = 1.0,
    gait: int | None = None,
    per: Per = "second",
) -> ChosenValue | None:
    (axis,) = {"speed", "cycle_duration"} - task.keys()
    return Chooser(atlas, within, scale, axis, per).cheapest(task, gait)


def test_the_bottom_of_a_bowl(bowl: Atlas) -> None:
    found = cheapest(bowl, domain(), {"speed": 0.5}, 10.0)
    assert found is not None
    assert found.value == pytest.approx(0.73, abs=1e-4)
    assert found.cost_per_second == pytest.approx(15.0, abs=1e-6)
    assert found.cost_per_metre == pytest.approx(30.0, abs=1e-5)
    assert found.on_edge is False
    other = cheapest(bowl, domain(), {"speed": 0.5}, 10.0, gait=1)
    assert other is not None and other.value == pytest.approx(1.1, abs=1e-4)


@pytest.mark.parametrize(
    ("feasible", "value"),
    [
        ([False, False, True, True, True, True], 0.8),
        ([True, True, False, False, False, False], 0.6),
        ([False, False, False, True, False, False], 1.0),
        ([True, False, True, False, False, True], 0.8),
    ],
)
def test_an_edge_is_met_exactly_and_said(bowl: Atlas, feasible: list[bool], value: float) -> None:
    found = cheapest(bowl, domain(feasible), {"speed": 0.5}, 1.0)
    assert found is not None
    assert (found.value, found.on_edge) == (value, True)


def test_nothing_to_choose_from(bowl: Atlas) -> None:
    assert cheapest(bowl, domain([False] * 6), {"speed": 0.5}, 1.0) is None
    assert cheapest(bowl, domain(), {"speed": 1.5}, 1.0) is None
    assert cheapest(bowl, domain([False] * 5 + [True]), {"speed": 0.5}, 1.0, gait=1) is None
    at_rest = cheapest(bowl, domain(), {"speed": 0.0}, 1.0)
    assert at_rest is not None and at_rest.cost_per_metre == float("inf")


def test_a_speed_has_another_cost_a_metre_than_a_second(bowl: Atlas) -> None:
    """A second costs 1.0049 + v at 0.8 s, least at rest; and so a metre 1 + 1.0049 / v, least when fast."""
    slow, fast = (cheapest(bowl, domain(), {"cycle_duration": 0.8}, per=per) for per in ("second", "metre"))
    assert slow is not None and (slow.axis, slow.value, slow.on_edge) == ("speed", 0.0, True)
    assert slow.cost_per_second == pytest.approx(1.0049) and slow.cost_per_metre == float("inf")
    assert fast is not None and (fast.value, fast.on_edge) == (1.0, True)
    assert fast.cost_per_metre == pytest.approx(2.0049)


def test_only_one_axis_of_the_command_is_left_to_the_map() -> None:
    axes = ("speed", "cycle_duration", "slope")
    assert left_out(axes, {"speed": 1.0, "slope": 0.0}) == "cycle_duration"
    assert left_out(axes, {"cycle_duration": 1.0, "slope": 0.0}) == "speed"
    assert left_out(axes, {"cycle_duration": 1.0, "speed": 0.0}) is None
    assert left_out(axes, {"slope": 1.0}) is None and left_out(axes, dict.fromkeys(axes, 0.0)) is None


@pytest.fixture(scope="module")
def gait_map(pristine: Path) -> GaitMap:
    return GaitMap.load(pristine)


@pytest.mark.parametrize("speed", [0.3, 0.9, 1.7, 2.1])
def test_speed_alone(gait_map: GaitMap, speed: float) -> None:
    choice, plan = gait_map.select(speed=speed), gait_map.plan(speed=speed)
    assert choice.in_domain and choice.chosen is not None
    assert choice.chosen.axis == "cycle_duration"
    assert choice.chosen.value == choice.cycle_duration == plan.task["cycle_duration"]
    assert plan.chosen == choice.chosen and plan.gait == choice.gait
    assert choice.chosen.cost_per_second == pytest.approx(plan.cost / choice.cycle_duration, rel=0.1)
    given = gait_map.select(speed, choice.cycle_duration)
    assert replace(choice, chosen=None) == given and given.chosen is None
    atlas, allowed = gait_map._artifact.atlas, []
    for duration in np.linspace(0.4, 1.2, 161):
        if gait_map.select(speed, duration).in_domain:
            allowed.append(float(duration))
            costs, support = atlas.costs(np.array([speed, duration]))
            rate = costs[support >= 0.7].min(initial=np.inf) * gait_map.manifest.cost_scale / duration
            assert rate >= choice.chosen.cost_per_second * (1 - 1e-3)
    ends = gait_map.manifest.domain.axes["cycle_duration"]
    assert choice.chosen.on_edge == (choice.cycle_duration in ends)
    assert min(allowed) - 0.01 < choice.cycle_duration < max(allowed) + 0.01


def test_the_duration_of_a_gait_that_is_asked_for(gait_map: GaitMap) -> None:
    plan = gait_map.plan(speed=0.9, gait="walking")
    assert plan.gait == "walking" and plan.chosen is not None and plan.feasible


def test_noise_does_not_change_the_duration(checkout: Path) -> None:
    """Under J1 the cost a second is nearly the same for many durations: without the choice before it jumps about."""
    effort = GaitMap.load(checkout / "models/half-cheetah-exact-effort")
    speeds = (0.75 + np.random.default_rng(0).normal(0, 0.01, 100)).tolist()
    free = {round(effort.select(speed=speed).cycle_duration, 2) for speed in speeds}
    assert len(free) > 3
    choice = effort.select(speed=0.75)
    held = []
    for speed in speeds:
        choice = effort.select(speed=speed, previous=choice)
        held.append((choice.gait, choice.cycle_duration))
        assert choice.chosen is not None and choice.chosen.value == choice.cycle_duration
    assert len(set(held)) == 1


def test_a_gait_kept_has_its_own_duration(gait_map: GaitMap) -> None:
    choice = gait_map.select(speed=0.9)
    other = next(gait.name for gait in gait_map.gaits if gait.name != choice.gait)
    before = replace(choice, gait=other, chosen=None)
    kept = gait_map.select(speed=0.9, previous=before, margin=1e6)
    assert kept.gait == other and kept.cycle_duration == gait_map.plan(speed=0.9, gait=other).task["cycle_duration"]
    assert gait_map.select(speed=0.9, previous=choice) == choice


def test_outside_there_is_nothing_to_choose(gait_map: GaitMap) -> None:
    for ask in (gait_map.select, gait_map.plan):
        with pytest.raises(
            OutOfDomain, match=r"speed = 9: the map knows no cost at any cycle_duration there; give one"
        ):
            ask(speed=9.0)


def test_the_speed_at_which_a_way_costs_least(checkout: Path) -> None:
    """What animals do: of ANYmal's energy a metre takes least at a speed within its map, a second least when slow."""
    energy = GaitMap.load(checkout / "models/anymal-energy")
    thrifty, slow = energy.select(cycle_duration=0.6, per="metre"), energy.select(cycle_duration=0.6)
    assert thrifty.chosen is not None and slow.chosen is not None
    assert slow.speed == energy.manifest.domain.axes["speed"][0] and slow.chosen.on_edge
    assert thrifty.speed > slow.speed and thrifty.chosen.cost_per_metre < slow.chosen.cost_per_metre
    for speed in np.linspace(0.2, 1.2, 21).tolist():
        costs, support = energy._artifact.atlas.costs(np.array([speed, 0.6]))
        if energy.select(speed, 0.6).in_domain and (support >= 0.7).any():
            metre = costs[support >= 0.7].min() * energy.manifest.cost_scale / (0.6 * speed)
            assert metre >= thrifty.chosen.cost_per_metre * (1 - 1e-3)
    with pytest.raises(ValueError, match="per = 'mile': must be 'second' or 'metre'"):
        energy.select(speed=0.6, per="mile")  # type: ignore[arg-type]


def test_the_ground_is_not_chosen(checkout: Path) -> None:
    slopes = GaitMap.load(checkout / "models/half-cheetah-exact-slopes")
    with pytest.raises(ValueError, match="a task here needs cycle_duration, slope as well"):
        slopes.select(speed=0.9)
    up, down = slopes.select(speed=0.9, slope=10.0), slopes.select(speed=0.9, slope=-10.0)
    assert up.chosen is not None and down.chosen is not None and up.task["slope"] == 10.0
