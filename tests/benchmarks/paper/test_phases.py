from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.paper import phases
from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.core.gaits import Pattern, Symmetry, gait_of
from gaitflow.core.names import gait_name

TROT, CRAWL = "0011/1100/1100/0011", "01111111/11011111/11110111/11111101"
LEGS, MIRROR = ("LF", "RF", "LH", "RH"), Symmetry(mirror=(1, 0, 3, 2))


@pytest.fixture
def pair(checkout: Path) -> tuple[Scenario, Scenario]:
    folder = checkout / "configs" / "scenarios"
    return tuple(load_scenario(folder / f"anymal-flat-vibration{end}.yaml") for end in ("", "-eight-phases"))  # type: ignore[return-value]


def labels(tasks: list[tuple[float, str, float]]) -> pd.DataFrame:
    rows = []
    for speed, pattern, cost in tasks:
        gait = gait_of(Pattern.from_text(pattern), MIRROR)
        name = gait_name(gait, LEGS)
        rows.append({
            "speed": speed, "cycle_duration": 0.5, "split": "grid", "status": "solved", "gait": name,
            "gait_key": gait.text, "pattern": pattern, "cost": cost, "margin": 0.1, "runner_up": "", "ties": [name],
        })  # fmt: skip
    return pd.DataFrame(rows)


def test_tasks_in_common_say_what_more_phases_gain(pair: tuple[Scenario, Scenario]) -> None:
    four = labels([(0.3, TROT, 100.0), (0.4, TROT, 90.0), (0.8, TROT, 50.0)])
    eight = labels([(0.3, CRAWL, 80.0), (0.8, "00001111/11110000/11110000/00001111", 50.0)])
    done = phases.run(*pair, four, eight)
    assert [row["speed"] for row in done["rows"]] == [0.3, 0.8]
    assert done["rows"][0]["cost_fall"] == pytest.approx(0.2)
    assert (done["rows"][0]["changed"], done["rows"][1]["changed"]) == (True, False)
    assert done["scenario"] == "anymal-flat-vibration-eight-phases"
    assert np.isclose(done["summary"]["cost_fall_max"], 0.2)


def test_the_control_divides_the_fall(pair: tuple[Scenario, Scenario]) -> None:
    four = labels([(0.3, TROT, 100.0), (0.8, TROT, 50.0), (0.9, TROT, 50.0)])
    eight = labels([(0.3, CRAWL, 60.0), (0.8, CRAWL, 45.0), (0.9, CRAWL, 45.0)])
    done = phases.run(*pair, four, eight, labels([(0.3, TROT, 80.0), (0.8, TROT, 40.0)]))
    told = [(row["fall_by_limit"], row["fall_by_phases"]) for row in done["rows"]]
    assert told[:2] == [pytest.approx((0.2, 0.25)), pytest.approx((0.2, -0.125))]
    assert told[2] == (None, None)
    assert done["summary"]["fall_by_phases_min"] == pytest.approx(-0.125)
    assert "fall_by_limit_max" not in phases.run(*pair, four, eight)["summary"]


def test_only_phases_and_stances_may_differ(pair: tuple[Scenario, Scenario]) -> None:
    four, eight = pair
    frame = labels([(0.3, TROT, 100.0)])
    slippery = eight.tasks.model_copy(update={"axes": eight.tasks.axes | {"friction": 0.5}})
    with pytest.raises(ValueError, match="axes differs"):
        phases.run(four, eight.model_copy(update={"tasks": slippery}), frame, frame)
    with pytest.raises(ValueError, match="4 of 10; it must have more phases and as many knots"):
        phases.run(four, four, frame, frame)
