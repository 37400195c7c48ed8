"""What the yardstick makes of its rows, and one task of it in the real MuJoCo."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from benchmarks.clients import walk
from benchmarks.rows import Row
from gaitflow.clients.description import describe
from gaitflow.config.scenario import load_scenario
from gaitflow.runtime import GaitMap


def row(source: str, gait: str, energy: float, **others: Any) -> Row:
    values = {"speed": 0.6, "cycle_duration": 0.6, "conditions": "as planned", "walked": True, "model": 0.5}
    return {**values, "source": source, "gait": gait, "energy": energy, "crocoddyl": 1.0, **others}


GOOD = [
    row("pick", "trot", 0.20, model=0.18),
    row("map", "pace", 0.30, model=0.25),
    row("map", "amble", 0.25, model=0.26),
    row("hand-made", "trot of duty 0.5", 0.40),
    row("hand-made", "bound of duty 0.5", 0.19, walked=False),
]


def test_a_pick_is_judged_among_all_that_walk() -> None:
    found = walk.summary(GOOD)
    assert (found["tasks"], found["picks_walked"], found["picks_at_most_the_best_trot"]) == (1, 1, 1)
    assert found["energy_over_best_trot_median"] == pytest.approx(0.5)
    assert found["regret_median"] == 0.0 and found["picks_near_the_best"] == 1
    assert found["kendall_of_own_median"] == pytest.approx(1 / 3)  # one of three pairs the other way round
    assert found["kendall_median"] == pytest.approx(2 / 3)  # one of six: the trot is dearest in both
    assert found["walked"]["hand-made"] == {"as planned": "0 of 1"}
    assert found["walked"]["trot"] == {"as planned": "1 of 1"}


def test_a_pick_that_falls_beats_nothing() -> None:
    fallen = [GOOD[0] | {"walked": False, "energy": 0.01}, *GOOD[1:]]
    found = walk.summary(fallen)
    assert (found["picks_walked"], found["picks_at_most_the_best_trot"], found["picks_near_the_best"]) == (0, 0, 0)
    assert found["regret_median"] is None and found["kendall_of_own_median"] is None


def test_a_dearer_pick_is_behind_the_trot() -> None:
    dearer = [GOOD[0] | {"energy": 0.5}, *GOOD[1:]]
    found = walk.summary(dearer)
    assert found["picks_at_most_the_best_trot"] == found["picks_near_the_best"] == 0
    assert found["regret_worst"] == pytest.approx(1.0)


def test_disturbed_walks_are_counted_apart() -> None:
    pushed = [GOOD[0] | {"conditions": "pushed", "walked": walked, "energy": 9.0} for walked in (True, False)]
    found = walk.summary([*GOOD, *pushed])
    assert found["walked"]["pick"] == {"as planned": "1 of 1", "pushed": "1 of 2"}
    assert found["regret_median"] == 0.0


@pytest.mark.parametrize(("name", "expected"), [("anymal", 0.1 * 15 / 80), ("go1", 0.1 * 30.1 / 23.7)])
def test_heat_follows_from_a_motors_limits(checkout: Path, name: str, expected: float) -> None:
    """The scenarios of energy have the same numbers, rounded."""
    scenario = load_scenario(checkout / f"configs/scenarios/{name}-energy.yaml")
    found = walk.heat_of(describe(scenario.as_data()))
    assert found == pytest.approx(expected, rel=1e-3)
    assert scenario.objective.joint_heat == pytest.approx(found, rel=0.1)


@pytest.mark.slow
def test_one_task_of_a_published_map(checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a part of what the yardstick walks, which takes minutes."""
    monkeypatch.setattr(walk, "CYCLES", 3)
    monkeypatch.setattr(walk, "OTHER_GAITS", 1)
    monkeypatch.setattr(walk, "HAND_MADE", (("trot", 0.5), ("pace", 0.5)))
    monkeypatch.setattr(walk, "DISTURBED", {"mass +10 %": walk.DISTURBED["mass +10 %"]})
    scenario = load_scenario(checkout / "configs/scenarios/go1-exact-vibration.yaml")
    folder = max((checkout / "models/go1-exact-vibration").iterdir())
    done = walk.run(scenario, folder, tmp_path, tasks=1)
    planned = [row for row in done["rows"] if row["conditions"] == "as planned"]
    assert {row["source"] for row in planned} == {"pick", "map", "hand-made"}
    assert len([row for row in planned if row["source"] == "hand-made"]) == len(walk.HAND_MADE) == 2
    assert {row["conditions"] for row in done["rows"]} == {"as planned", "mass +10 %"}
    assert GaitMap.load(folder).select(**{k: planned[0][k] for k in ("speed", "cycle_duration")}).gait in {
        row["gait"] for row in planned
    }
    assert all(row["energy"] > 0 for row in planned if row["walked"]) and done["summary"]["tasks"] == 1
    assert walk.run(scenario, folder, tmp_path, tasks=1)["rows"] == done["rows"]  # kept
