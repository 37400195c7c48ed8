"""Two maps of the same tasks beside each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import PathCollection

from gaitflow.config.scenario import Transcription
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.report.side_by_side import LabelledMap, compare, draw_side_by_side

TIME_SYMMETRIC = Transcription(integrator="momentum", forces="linear")


def costs_of(labels: pd.DataFrame, dearer: float = 0.1) -> pd.DataFrame:
    """The label's gait, and bounding at `dearer` more where that is not the label."""
    best = labels[labels["status"] == "solved"][["speed", "cycle_duration", "split", "gait", "gait_key", "cost"]]
    key = gait_of(Pattern.from_text("0001/0100")).text
    other = best[best["gait_key"] != key].assign(gait="bounding", gait_key=key)
    return pd.concat([best, other.assign(cost=other["cost"] * (1 + dearer))], ignore_index=True)


@pytest.fixture(scope="module")
def maps(scenario, labels) -> tuple[LabelledMap, LabelledMap]:
    """Euler's says bounding on eight tasks of the exact map's walking."""
    wrong, merged = labels.copy(), labels.copy()
    merged.loc[labels["gait"] == "pronking", ["gait", "gait_key"]] = ["gallop-pronk", "001/011"]
    exact = LabelledMap(scenario.model_copy(update={"transcription": TIME_SYMMETRIC}), merged, costs_of(merged))
    walking = labels.index[labels["gait"] == "walking"][:8]
    wrong.loc[walking, ["gait", "gait_key"]] = ["bounding", gait_of(Pattern.from_text("0001/0100")).text]
    return LabelledMap(scenario, wrong, costs_of(wrong)), exact


def test_labels_that_changed_are_told_with_what_eulers_gait_costs(maps) -> None:
    found = compare(*maps)
    assert len(found) == 83 + 25, "the infeasible task is left out"
    changed = found[found["changed"]]
    assert len(changed) == 8
    assert set(changed["euler"]) == {"bounding"} and set(changed["exact"]) == {"walking"}
    np.testing.assert_allclose(changed["excess"], 0.1)
    np.testing.assert_allclose(found.loc[~found["changed"], "excess"], 0.0)


def test_a_gait_without_a_motion_on_the_exact_map_has_no_excess(maps) -> None:
    euler, exact = maps
    bare = replace(exact, costs=exact.costs[exact.costs["gait"] != "bounding"])
    assert compare(euler, bare).query("changed")["excess"].isna().all()


def test_a_gait_and_its_time_reversal_are_no_change_where_the_map_merges_them(maps) -> None:
    _, exact = maps
    pair = [gait_of(Pattern.from_text(text)).text for text in ("0110/0100", "0010/0110")]
    assert pair[0] != pair[1]
    row = exact.labels.iloc[:1]
    one, two = (
        row.assign(gait=name, gait_key=key) for name, key in zip(("pronking", "gallop-pronk"), pair, strict=True)
    )
    reversible = LabelledMap(exact.scenario, two, costs_of(two))
    assert not compare(LabelledMap(exact.scenario, one, costs_of(one)), reversible)["changed"].any()
    slope = {**exact.scenario.tasks.as_data()["axes"], "slope": 20.0}
    tasks = type(exact.scenario.tasks).from_data({"axes": slope}, "tasks")
    uphill = LabelledMap(exact.scenario.model_copy(update={"tasks": tasks}), two, costs_of(two))
    assert compare(LabelledMap(exact.scenario, one, costs_of(one)), uphill)["changed"].all()


def test_changed_tasks_are_framed_on_both_maps(maps) -> None:
    figure = draw_side_by_side(*maps, "a title")
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["forward Euler", "exact motion"]
    for axes in figure.axes:
        frame = [item for item in axes.collections if isinstance(item, PathCollection)][-1]
        assert len(frame.get_offsets()) == 8
    assert figure.get_suptitle() == "a title: 8 of 108 labels changed"


def test_maps_of_three_axes_are_refused(sloped, sloped_labels) -> None:
    both = LabelledMap(sloped, sloped_labels, costs_of(sloped_labels))
    with pytest.raises(ValueError, match="3 axes; two maps stand side by side over two"):
        draw_side_by_side(both, both, "title")
