"""A gait is kept at a border between two, and nowhere else."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitflow.runtime import Choice, GaitMap

CYCLE = 0.6


@pytest.fixture(scope="module")
def gait_map(checkout: Path) -> GaitMap:
    return GaitMap.load(checkout / "models/half-cheetah-exact-vibration")


@pytest.fixture(scope="module")
def omni(checkout: Path) -> GaitMap:
    return GaitMap.load(checkout / "models/anymal-omni")


@pytest.fixture(scope="module")
def borders(gait_map: GaitMap) -> list[float]:
    """Speeds [m/s] at which the cheapest gait changes."""
    speeds = np.linspace(0.1, 2.3, 221).tolist()
    gaits = [gait_map.select(speed, CYCLE).gait for speed in speeds]
    found = []
    for (low, before), (high, after) in pairwise(zip(speeds, gaits, strict=True)):
        if None in (before, after) or before == after:
            continue
        a, b = low, high
        while b - a > 1e-9:
            middle = (a + b) / 2
            a, b = (middle, b) if gait_map.select(middle, CYCLE).gait == before else (a, middle)
        found.append(b)
    assert len(found) >= 2
    return found


def flips(choices: list[Choice]) -> int:
    return sum(one.gait != other.gait for one, other in pairwise(choices))


def test_noise_at_a_border_does_not_flip_the_gait(gait_map: GaitMap, borders: list[float]) -> None:
    for border in borders:
        speeds = (border + np.random.default_rng(0).normal(0, 0.01, 1000)).tolist()
        free = [gait_map.select(speed, CYCLE) for speed in speeds]
        assert flips(free) > 300
        held = [free[0]]
        for speed in speeds[1:]:
            held.append(gait_map.select(speed, CYCLE, previous=held[-1]))
        assert flips(held) <= 10


def test_the_gait_is_kept_within_the_margin_and_no_further(gait_map: GaitMap, borders: list[float]) -> None:
    border, steps = borders[0], gait_map.manifest.domain.steps
    before, here = gait_map.select(border - 0.05, CYCLE), gait_map.select(border + 0.05, CYCLE)
    assert here.gait != before.gait
    moves = [(0.0, 0.0), *(tuple(sign * 0.1 * move) for move in np.diag(steps) for sign in (-1, 1))]
    least = min(excess(gait_map, before.gait, border + 0.05 + v, CYCLE + t) for v, t in moves)
    assert 0.05 < least < excess(gait_map, before.gait, border + 0.05, CYCLE)
    kept = gait_map.select(border + 0.05, CYCLE, previous=before, margin=least * 1.001)
    assert kept.gait == before.gait == kept.ranked[0][0]
    assert kept.probability == kept.ranked[0][1] == dict(here.ranked)[kept.gait]
    assert [each for each in here.ranked if each[0] != kept.gait] == list(kept.ranked[1:])
    for margin in (least * 0.999, 0.05, 0.0):
        assert gait_map.select(border + 0.05, CYCLE, previous=before, margin=margin) == here


def excess(gait_map: GaitMap, gait: str | None, *place: float) -> float:
    """By how much a gait is predicted to cost more than the best one."""
    atlas = gait_map._artifact.atlas
    costs, _ = atlas.costs(np.array(place))
    names = {gait_map.gaits[atlas.sheets[sheet].gait].name: sheet for sheet in atlas.ranked(np.array(place))}
    return float(costs[names[str(gait)]] / costs[atlas.ranked(np.array(place))[0]] - 1)


def test_over_many_axes_a_gait_is_kept_by_what_the_gait_is_chosen_by(omni: GaitMap) -> None:
    standing = {"lateral_speed": 0.0, "yaw_rate": 0.0, "cycle_duration": 0.6}
    atlas, gaits = omni._artifact.atlas, [gait.name for gait in omni.gaits]
    choices = [omni.select(speed, **standing) for speed in np.linspace(0.0, 1.2, 61).tolist()]
    changes = [(one, other) for one, other in pairwise(choices) if one.gait != other.gait]
    assert changes
    for before, here in changes:
        place = np.array([here.task[axis] for axis in omni.axes])
        chances = omni._probabilities(place)
        costs, _ = atlas.costs(place)
        old, new = (
            next(
                float(costs[sheet]) / chances[atlas.sheets[sheet].gait]
                for sheet in atlas.ranked(place, chances)
                if gaits[atlas.sheets[sheet].gait] == name
            )
            for name in (before.gait, here.gait)
        )
        kept = omni.select(**here.task, previous=before, margin=old / new - 1 + 1e-9)
        assert kept.gait == before.gait


def test_a_previous_choice_without_a_gait_changes_nothing(gait_map: GaitMap) -> None:
    outside = gait_map.select(9.0, CYCLE)
    assert outside.gait is None
    assert gait_map.select(0.9, CYCLE, previous=outside) == gait_map.select(0.9, CYCLE)
    inside = gait_map.select(0.9, CYCLE)
    assert gait_map.select(9.0, CYCLE, previous=inside) == outside


@pytest.mark.parametrize("previous", ["walking", 1, {}])
def test_what_is_no_choice(gait_map: GaitMap, previous: Any) -> None:
    with pytest.raises(ValueError, match=r"previous = .*: must be a choice"):
        gait_map.select(0.9, CYCLE, previous=previous)


@pytest.mark.parametrize("margin", [-0.1, np.nan, np.inf, "5 %", None, True])
def test_what_is_no_margin(gait_map: GaitMap, margin: Any) -> None:
    with pytest.raises(ValueError, match="margin = "):
        gait_map.select(0.9, CYCLE, margin=margin)


def test_a_gait_of_another_map(gait_map: GaitMap, checkout: Path) -> None:
    other = GaitMap.load(checkout / "models/anymal-flat-vibration").select(0.8, 0.6)
    with pytest.raises(ValueError, match=r"gait = '.*': the map has "):
        gait_map.select(0.9, CYCLE, previous=other)
