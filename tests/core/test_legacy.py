from __future__ import annotations

import copy
import json
from pathlib import Path

import pytest

from gaitflow.core.layout import Layout
from gaitflow.core.legacy import modern_name, modern_scenario
from gaitflow.core.task import Task
from gaitflow.core.task_space import TaskSpace

MODELS = Path(__file__).parents[2] / "models"
OLD = json.loads((MODELS / "half-cheetah-slope20-vibration" / "1.1.0" / "manifest.json").read_text())["scenario"]


def test_terrain_and_ranges_become_axes() -> None:
    before = copy.deepcopy(OLD)
    modern = modern_scenario(OLD)
    assert before == OLD, "the argument is not changed"
    assert "terrain" not in modern
    assert modern["tasks"] == {
        "axes": {**{axis: OLD["tasks"][axis] for axis in ("speed", "cycle_duration")}, "slope": 20.0, "friction": 0.8},
        "held_out": OLD["tasks"]["held_out"],
        "held_out_seed": OLD["tasks"]["held_out_seed"],
    }
    assert modern["transcription"] == {**OLD["transcription"], "forces": "held", "grading": 0.0}
    assert modern["robot"] == OLD["robot"]


@pytest.mark.parametrize("part", ["transcription", "strategy", "learning"])
def test_what_every_published_scenario_says_has_no_default(part: str) -> None:
    modern = modern_scenario(OLD)
    for odd in ({key: value for key, value in modern.items() if key != part}, modern | {part: {}}):
        with pytest.raises(ValueError, match=rf"a scenario without {part}\.(phases|name|tie_tolerance)"):
            modern_scenario(odd)


def test_what_reads_scenarios_reads_it() -> None:
    modern = modern_scenario(OLD)
    space = TaskSpace.of(modern)
    assert space.ranged == ("speed", "cycle_duration")
    assert space.task({"speed": 0.9, "cycle_duration": 0.6}) == Task.of(
        {"speed": 0.9, "cycle_duration": 0.6, "slope": 20.0, "friction": 0.8}
    )
    assert Layout.of(modern).nw == 734


def test_todays_form_passes() -> None:
    modern = modern_scenario(OLD)
    assert modern_scenario(modern) == modern


@pytest.mark.parametrize("missing", ["terrain", "tasks", "transcription"])
def test_neither_form_is_refused(missing: str) -> None:
    with pytest.raises(ValueError, match=r"without tasks\.axes"):
        modern_scenario({key: value for key, value in OLD.items() if key != missing})


@pytest.mark.parametrize(
    ("name", "today"),
    [
        ("four-beat walk 0001/0100/0010/1000", "four-beat grounded run 0001/0100/0010/1000"),
        ("four-beat grounded run 0001/0100/0010/1000", "four-beat grounded run 0001/0100/0010/1000"),
        ("three-beat walk 0011/1110/1110/1001", "three-beat walk 0011/1110/1110/1001"),
        ("four-beat walk", "four-beat walk"),
        ("trot", "trot"),
        ("four-beat walk 0001/01", "four-beat walk 0001/01"),
    ],
)
def test_grounded_runs_that_were_called_walks(name: str, today: str) -> None:
    assert modern_name(name) == today
