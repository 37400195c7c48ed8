"""`gaitflow models`: the list of published maps, and where two of them disagree."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from gaitflow.cli import main
from gaitflow.runtime import GaitMap


def models(root: Path, *arguments: object) -> Result:
    return CliRunner().invoke(main, ["--root", str(root), "models", *map(str, arguments)])


def test_the_list_has_every_version_and_says_which_cannot_be_read(checkout: Path, tmp_path: Path) -> None:
    name = "half-cheetah-exact-vibration"
    shutil.copytree(checkout / "models" / name, tmp_path / "models" / name)
    (tmp_path / "models" / name / "9.0.0").mkdir()
    rows = json.loads(models(tmp_path, "list", "--json").stdout)
    assert [Path(row["folder"]).name for row in rows][-1] == "9.0.0" and "manifest.json" in rows[-1]["fault"]
    assert rows[0]["gaits"] == [gait.name for gait in GaitMap.load(rows[0]["folder"]).gaits]
    assert rows[0]["regret_mean"] is not None and rows[0]["axes"] == {"speed": [0.1, 2.3], "cycle_duration": [0.4, 1.6]}
    told = models(tmp_path, "list").stdout.splitlines()
    assert told[0].startswith(f"{name} {rows[0]['version']}: half_cheetah, speed, cycle_duration, 4 gaits")
    assert "9.0.0: cannot be read" in told[-1]
    assert "no map is published in" in models(tmp_path / "models", "list").stdout


def test_a_map_does_not_differ_from_itself(checkout: Path) -> None:
    model = checkout / "models/half-cheetah-exact-vibration"
    found = json.loads(models(checkout, "diff", model, model, "--json").stdout)
    assert found["tasks"] == 84 and found["disagreements"] == [] and found["gaits_first"] == []


def test_maps_are_asked_where_both_answer_and_each_says_what_the_others_gait_costs(checkout: Path) -> None:
    """One map ranges over slopes, the other holds the slope at 0."""
    first, second = (checkout / f"models/half-cheetah-exact-{name}/1.1.0" for name in ("slopes", "vibration"))
    found = json.loads(models(checkout, "diff", first, second, "--json").stdout)
    maps = GaitMap.load(first), GaitMap.load(second)
    assert found["tasks"] > 84 and found["disagreements"]
    for one in found["disagreements"]:
        assert one["task"]["slope"] == 0.0 and one["first"] != one["second"]
        flat = {axis: one["task"][axis] for axis in ("speed", "cycle_duration")}
        assert (maps[0].select(**one["task"]).gait, maps[1].select(**flat).gait) == (one["first"], one["second"])
        assert one["first_excess"] > 0 and one["second_excess"] > 0, "each map's own gait is the cheapest by its atlas"
    told = models(checkout, "diff", first, second).stdout
    assert f"at {len(found['disagreements'])} (" in told and "slope 0 deg: gallop-bound / " in told


def test_gaits_of_other_legs_are_not_compared(checkout: Path) -> None:
    first, second = (checkout / "models" / name for name in ("anymal-energy", "half-cheetah-exact-vibration"))
    done = models(checkout, "diff", first, second)
    assert done.exit_code == 2 and "has the legs LF, RF, LH, RH" in done.stderr and len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize("other", ["nowhere", "datasets/half-cheetah-exact-vibration"])
def test_what_is_no_map_is_one_line(checkout: Path, other: str) -> None:
    done = models(checkout, "diff", checkout / "models/half-cheetah-exact-vibration", checkout / other)
    assert done.exit_code == 2 and other in done.stderr and len(done.stderr.splitlines()) == 1
