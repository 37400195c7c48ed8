from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from gaitflow.publishing.card import card
from gaitflow.runtime.manifest import read_manifest


def test_card_tells_what_where_how_good_and_how_to_load(pristine: Path) -> None:
    text = (pristine / "README.md").read_text(encoding="utf-8")
    for part in (
        "# quickstart 1.0.0",
        "planar, 2D rigid body of 14 kg, legs F, H",
        "slope 0 degrees, friction coefficient 0.8",
        "weights: force 1",
        "0.1 to 2.1 (6 values) m/s",
        "Of the 24 tasks of the grid\n23 have a feasible gait",
        "| gallop | `F 0110 / H 1100` |",
        "| accuracy | 0.97 |",
        'GaitMap.load("models/quickstart/1.0.0")',
        "BSD-3-Clause",
        "a source you trust",
    ):
        assert part in text, part


def test_card_is_what_the_manifest_says_and_no_more(pristine: Path) -> None:
    manifest = read_manifest(pristine)
    assert card(manifest) == (pristine / "README.md").read_text(encoding="utf-8")


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


def test_every_table_row_has_the_columns_of_its_head(pristine: Path) -> None:
    rows = [line for line in (pristine / "README.md").read_text(encoding="utf-8").splitlines() if line.startswith("|")]
    assert {row.count("|") for row in rows} == {3}
