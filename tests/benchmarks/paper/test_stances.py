from __future__ import annotations

import json
import math
from pathlib import Path

import pandas as pd
import pytest

from benchmarks.paper.stances import compare, run, summarise
from gaitflow.config.scenario import Scenario, load_scenario

GALLOP, TWO_HOPS = ("gallop", "0011/0110"), ("F 0101 / H 0101", "0101/0101")
HOP, ONE_LEG = ("F 01 / H 01", "01/01"), ("F 01 / H 00", "01/00")


def labels(rows: list[tuple[tuple[str, str] | None, float, list[str]]], split: str = "grid") -> pd.DataFrame:
    """A row a speed 0.1, 0.2, ...: gait (name, canonical text) or None, its cost, and what ties with it beside it."""
    return pd.DataFrame(
        [
            {
                "speed": 0.1 * (n + 1), "cycle_duration": 0.6, "split": split,
                "status": "solved" if gait else "infeasible", "gait": gait[0] if gait else "",
                "gait_key": gait[1] if gait else "", "cost": cost, "ties": [gait[0], *ties] if gait else [],
            }
            for n, (gait, cost, ties) in enumerate(rows)
        ]
    )  # fmt: skip


ONE = labels([(GALLOP, 10.0, []), (GALLOP, 10.0, []), (GALLOP, 10.0, []), (GALLOP, 10.0, []), (None, math.nan, []),
              (GALLOP, 10.0, [])])  # fmt: skip
FREE = labels([(GALLOP, 10.0, []), (TWO_HOPS, 7.5, []), (TWO_HOPS, 9.999, ["gallop"]), (HOP, 10.01, []),
               (ONE_LEG, 5.0, []), (None, math.nan, [])])  # fmt: skip


def test_what_changes_and_by_how_much_the_cost_falls() -> None:
    rows = compare(ONE, FREE)
    assert [row["changed"] for row in rows] == [False, True, True, True, False, False]
    assert [row["changed_beyond_ties"] for row in rows] == [False, True, False, True, False, False]
    assert [row["excluded"] for row in rows] == [False, True, True, False, True, False]
    assert [row["dearer"] for row in rows] == [False, False, False, True, False, False]
    assert rows[1]["cost_fall"] == pytest.approx(0.25)
    assert rows[3]["cost_fall"] == pytest.approx(-0.001)
    assert rows[4]["cost_fall"] is None
    assert (rows[4]["gait"], rows[4]["free_gait"]) == (None, "F 01 / H 00")


def test_summary_of_planted_labels() -> None:
    summary = summarise(compare(ONE, FREE))
    assert summary["winners"] == {"F 0101 / H 0101": 2, "F 01 / H 01": 1}
    assert {key: summary[key] for key in ("tasks", "compared", "changed", "changed_beyond_ties", "excluded")} == {
        "tasks": 6, "compared": 4, "changed": 3, "changed_beyond_ties": 2, "excluded": 3,
    }  # fmt: skip
    assert (summary["dearer"], summary["only_found_without"], summary["only_found_with"]) == (1, 1, 1)
    assert summary["cost_fall_max"] == pytest.approx(0.25)
    assert summary["cost_fall_median"] == pytest.approx(0.00005)
    assert summary["cost_fall_median_of_changed"] == pytest.approx(0.0001)


def test_order_and_held_out_tasks_do_not_matter() -> None:
    turned = pd.concat([labels([(GALLOP, 1.0, [])], "held_out"), FREE.iloc[::-1]], ignore_index=True)
    assert compare(ONE, turned) == compare(ONE, FREE)


def test_tasks_in_common_are_compared() -> None:
    assert compare(ONE, FREE.iloc[:5]) == compare(ONE, FREE)[:5]
    elsewhere = FREE.assign(speed=FREE["speed"] + 0.01)
    with pytest.raises(ValueError, match="6 and 6 grid tasks and none in common"):
        compare(ONE, elsewhere)


@pytest.fixture
def pair(checkout: Path) -> tuple[Scenario, Scenario]:
    folder = checkout / "configs" / "scenarios"
    return tuple(load_scenario(folder / f"half-cheetah-flat-effort{end}.yaml") for end in ("", "-free"))  # type: ignore[return-value]


def test_the_two_scenarios_differ_in_that_setting_alone(pair: tuple[Scenario, Scenario]) -> None:
    one, free = (scenario.as_data() for scenario in pair)
    assert {key for key in one if one[key] != free[key]} == {"name", "description", "stances_per_leg", "tasks"}
    assert {key for key in one["tasks"] if one["tasks"][key] != free["tasks"][key]} == {"held_out"}
    assert (one["stances_per_leg"], free["stances_per_leg"]) == (1, None)


def test_document_of_the_pair(pair: tuple[Scenario, Scenario]) -> None:
    done = run(*pair, ONE, FREE)
    assert (done["bench"], done["scenario"]) == ("stances", "half-cheetah-flat-effort")
    assert done["summary"]["changed"] == 3
    assert len(done["rows"]) == 6
    json.dumps(done, allow_nan=False)


def test_scenarios_that_cannot_be_compared_are_refused(pair: tuple[Scenario, Scenario]) -> None:
    one, free = pair
    with pytest.raises(ValueError, match=r"stances_per_leg is None in .*-free and 1 in half-cheetah-flat-effort"):
        run(free, one, FREE, ONE)
    heavier = free.model_copy(update={"robot": free.robot.model_copy(update={"mass": 15.0})})
    with pytest.raises(ValueError, match="robot differs"):
        run(one, heavier, ONE, FREE)
