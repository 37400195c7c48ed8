"""Within ties a label follows the neighbouring tasks, on grids over one, two and three axes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitflow.dataset.neighbours import neighbourhood_labels

# The gaits that tie at a task, the cheapest first.
TIES = {
    "W": ["walking"],
    "G": ["gallop"],
    "w": ["walking", "gallop"],
    "g": ["gallop", "walking"],
    "b": ["bounding", "gallop"],
    ".": [],
}
AXES = ["speed", "cycle_duration", "slope"]


def frame(tasks: Iterable[tuple[Sequence[float], str, str]]) -> pd.DataFrame:
    """Labels of (values, split, letter) tasks, as many axes as there are values."""
    rows = [
        dict(zip(AXES, values, strict=False))
        | {"split": split, "ties": TIES[letter], "label": TIES[letter][0] if TIES[letter] else ""}
        for values, split, letter in tasks
    ]
    return pd.DataFrame(rows)


def grid(rows: Sequence[str]) -> list[tuple[Sequence[float], str, str]]:
    """A map drawn with a letter a task, speeds to the right and durations downwards."""
    return [((v, t + 1), "grid", letter) for t, row in enumerate(rows) for v, letter in enumerate(row)]


def drawn(labels: Sequence[str], width: int) -> list[str]:
    letters = "".join(label[0] if label else "." for label in labels)
    return [letters[i : i + width] for i in range(0, len(letters), width)]


@pytest.mark.parametrize(
    ("ties", "expected"),
    [
        (["WWW", "WgW", "WWW"], ["www", "www", "www"]),  # noise inside a region goes
        (["WWW", "WGW", "WWW"], ["www", "wgw", "www"]),  # a gait that is really cheaper stays
        (["WWWGGG", "WgwgwG", "WWWGGG"], ["wwwggg", "wwwggg", "wwwggg"]),  # it spreads from task to task
        (["WWW", "WbW", "WWW"], ["www", "wbw", "www"]),  # never to a gait outside the ties
        (["w.g"], ["w.g"]),  # no neighbour, no change
        (["wg"], ["gg"]),  # and one that ties alone decides
    ],
)
def test_within_ties_a_label_follows_its_neighbourhood(ties: list[str], expected: list[str]) -> None:
    assert drawn(neighbourhood_labels(frame(grid(ties))), len(ties[0])) == expected


def test_neighbours_are_those_on_every_axis() -> None:
    line = frame([((v,), "grid", letter) for v, letter in enumerate("WgW")])
    assert neighbourhood_labels(line) == ["walking"] * 3
    # In the plane gallop has 8 of 8 votes; the walking tasks one step up and down the slope have 18 of 26.
    cube = [
        ((v, t, slope), "grid", "g" if (v, t, slope) == (1, 1, 0) else "G" if slope == 0 else "W")
        for slope in (-5, 0, 5)
        for t in range(3)
        for v in range(3)
    ]
    plane = [task for task in cube if task[0][2] == 0]
    assert neighbourhood_labels(frame(plane))[4] == "gallop"
    assert neighbourhood_labels(frame(cube))[13] == "walking"


def test_labels_do_not_depend_on_the_order_of_rows() -> None:
    table = frame(grid(["WwgG", "wgwg", "gwgw", "WgwG"]))
    backwards = table.iloc[::-1].reset_index(drop=True)
    assert neighbourhood_labels(table) == neighbourhood_labels(backwards)[::-1]


@given(st.lists(st.text("WGwgb.", min_size=5, max_size=5), min_size=1, max_size=5))
def test_every_label_ties_with_the_cheapest_gait_and_no_neighbourhood_outvotes_it(rows: list[str]) -> None:
    tasks = grid(rows)
    labels = neighbourhood_labels(frame(tasks))
    place = {tuple(values): label for (values, _, _), label in zip(tasks, labels, strict=True)}
    for ((v, t), _, letter), label in zip(tasks, labels, strict=True):
        assert label in (TIES[letter] or [""])
        around = [place.get((v + dv, t + dt)) for dv in (-1, 0, 1) for dt in (-1, 0, 1) if (dv, dt) != (0, 0)]
        assert all(around.count(gait) <= around.count(label) for gait in TIES[letter])


def test_held_out_tasks_follow_the_grid_and_never_lead_it() -> None:
    known = grid(["WWW", "WgW", "WWW"])
    held = [
        ((0.5, 1.5), "held_out", "g"),
        ((1.0, 2.0), "held_out", "G"),
        ((1.1, 2.1), "held_out", "G"),
        ((0.9, 2.1), "held_out", "g"),
    ]
    together = neighbourhood_labels(frame(known + held))
    assert together[: len(known)] == neighbourhood_labels(frame(known))
    assert together[len(known) :] == ["walking", "gallop", "gallop", "walking"]


def test_scattered_tasks_take_what_the_nearest_ones_have() -> None:
    walks = [((0.1 * i, 1.0 + 0.05 * (i % 3)), "sampled", "W") for i in range(8)]
    gallops = [((5.0 + 0.1 * i, 1.0 + 0.05 * (i % 3)), "sampled", "G") for i in range(8)]
    tied = [((0.35, 1.07), "sampled", "g"), ((5.35, 1.07), "held_out", "w")]
    labels = neighbourhood_labels(frame([*walks, *gallops, *tied]))
    assert labels == ["walking"] * 8 + ["gallop"] * 8 + ["walking", "gallop"]
