from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from gaitflow.publishing.card import card
from gaitflow.runtime.manifest_file import read_manifest


def test_card_tells_what_where_how_good_and_how_to_load(pristine: Path) -> None:
    text = (pristine / "README.md").read_text(encoding="utf-8")
    for part in (
        "# quickstart 1.0.0",
        "planar, 2D rigid body of 14 kg, legs F, H",
        "For a task, speed and cycle duration, it answers",
        "| friction | 0.8  |",
        "momentum, linear forces",
        "| dataset | quickstart 1.0.0 |",
        "weights: force 1",
        "| speed | 0.1 to 2.1 (6 values) m/s |",
        "Of the 24 tasks of the grid 23 have a feasible gait",
        "| gallop | `F 0110 / H 1100` |",
        "| accuracy | 0.97 |",
        'GaitMap.load("models/quickstart/1.0.0")',
        "BSD-3-Clause",
        "They are data",
    ):
        assert part in text, part


def test_card_is_what_the_manifest_says_and_no_more(pristine: Path) -> None:
    manifest = read_manifest(pristine)
    assert card(manifest) == (pristine / "README.md").read_text(encoding="utf-8")


def test_of_tasks_that_a_map_chose_the_grid_tells_only_the_domain(pristine: Path) -> None:
    manifest = read_manifest(pristine)
    assert "chosen anywhere between" not in card(manifest)
    scenario = dict(manifest.scenario)
    chosen = replace(manifest, scenario=scenario | {"tasks": scenario["tasks"] | {"sampling": "adaptive"}})
    assert "The grid tells the domain; the map was made from tasks chosen anywhere between." in card(chosen)


def test_competitors_make_a_row_each_and_unknown_numbers_a_dash(pristine: Path) -> None:
    quality = {"accuracy": 0.9, "macro_f1": 0.8, "top1_beyond_ties": 1.0, "regret_mean": 1.234e-3, "regret_p95": None}
    metrics = {
        "competitors": [{"method": "mlp", "cross_validation": quality, "held_out": {}}, {"method": "knn"}],
        "accuracy": 1,
    }
    text = card(replace(read_manifest(pristine), metrics=metrics))
    assert "| mlp, cross validation | 0.9 | 0.8 | 1 | 0.001234 | - | - |" in text
    assert "| mlp, held out | - | - | - | - | - | - |" in text
    assert "knn" not in text


def test_what_the_map_picks_and_how_good_predictions_are_is_told(pristine: Path) -> None:
    quality = dict.fromkeys(
        ("accuracy", "macro_f1", "top1_beyond_ties", "regret_mean", "regret_p95", "infeasible_rate"), 0.5
    )
    predictions = {"tasks": 100, "converged": 97, "iterations_mean": 6.54321, "iterations_p95": 9.0}
    metrics = {
        "competitors": [{"method": "mlp", "cross_validation": quality, "held_out": quality}],
        "published": {"atlas_tasks": 500, "held_out": quality, "map_held_out": quality | {"accuracy": 0.75}},
        "atlas": {
            "nodes": {"gallop 0110/1100": 20, "walking 0111/1101": 22},
            "predictions": predictions | {"cost_error_median": 0.0031, "cost_error_p95": None},
        },
    }
    text = card(replace(read_manifest(pristine), metrics=metrics))
    assert "| perceptron as published, fitted to 500 tasks of the atlas, too: held out | 0.5 |" in text
    assert "| **what the map picks: held out** | 0.75 |" in text
    assert "42 solved tasks of 2 patterns" in text
    assert "100 random tasks Newton's method reached the optimum 97 times" in text
    assert "6.543 iterations on average; predicted costs were off by 0.0031 (median) and - (95th" in text


def test_every_table_row_has_the_columns_of_its_head(pristine: Path) -> None:
    rows = [line for line in (pristine / "README.md").read_text(encoding="utf-8").splitlines() if line.startswith("|")]
    assert {row.count("|") for row in rows} == {3}
