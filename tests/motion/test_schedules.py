"""What other programs read: golden files, and schedules that agree with the states."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from bodies import PLANAR, SPATIAL
from cyclic import cyclic, cyclic_scenario
from hypothesis import given, settings
from hypothesis import strategies as st
from trotting import trot

from gaitflow.core.task import Task
from gaitflow.export.contact_parquet import write_contact_schedule
from gaitflow.motion import Motion, gait_info, schedule_data, schedule_json, towr_formulation
from gaitflow.motion.contact_schedule import intervals

GOLDEN = Path(__file__).parents[1] / "data" / "schedules"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("trot.json", lambda motion: schedule_json(motion, 2)),
        ("trot.info", lambda motion: gait_info(motion, "trot 01/10")),
        ("trot.towr", lambda motion: towr_formulation(motion, 2)),
    ],
)
def test_golden_files(name: str, text: Any) -> None:
    assert text(trot()) == (GOLDEN / name).read_text()


def test_a_table_of_stances(tmp_path: Path) -> None:
    motion = trot()
    write_contact_schedule(tmp_path / "trot.parquet", motion, 3)
    table = pq.read_table(tmp_path / "trot.parquet")
    assert table.column_names == ["leg", "start", "end", "x", "y", "z"]
    assert table.schema.metadata == {b"legs": b"LF,RF,LH,RH", b"cycle_duration": b"0.8"}
    expected = [(leg, *stance) for leg in motion.leg_names for stance in motion.phases(leg, 3)]
    for row, (leg, start, end, foothold) in zip(table.to_pylist(), expected, strict=True):
        assert (row["leg"], row["start"], row["end"]) == (leg, start, end)
        assert [row["x"], row["y"], row["z"]] == foothold.tolist()
    with pytest.raises(FileExistsError):
        write_contact_schedule(tmp_path / "trot.parquet", motion)
    planar = made(PLANAR, "0110/0000")
    write_contact_schedule(tmp_path / "trot.parquet", planar, replace=True)
    table = pq.read_table(tmp_path / "trot.parquet")
    assert table.column_names == ["leg", "start", "end", "x", "z"] and set(table["leg"].to_pylist()) == {"LF"}


def made(robot: dict[str, Any], pattern: str, seed: int = 0) -> Motion:
    data, task = cyclic_scenario(robot), Task.of({"speed": 0.5, "cycle_duration": 0.6})
    return Motion.of(data, cyclic(data, task, pattern, seed), task, pattern)


rows = st.sampled_from(["0110", "1100", "0111", "1001", "1010", "0000", "1111"])


@given(st.lists(rows, min_size=4, max_size=4).filter(lambda each: any("1" in row for row in each)), st.integers(1, 3))
@settings(max_examples=40)
def test_intervals_cover_the_cycles(pattern: list[str], cycles: int) -> None:
    motion = made(SPATIAL, "/".join(pattern))
    found = intervals(motion, cycles)
    assert found[0].start == 0 and found[-1].end == cycles * 0.6
    assert all(one.end == other.start and one.contact != other.contact for one, other in pairwise(found))
    for each in found:
        seen = motion.sample(np.linspace(each.start + 1e-6, each.end - 1e-6, 7)).contact
        assert (seen == each.contact).all()
    data = json.loads(schedule_json(motion, cycles))
    assert data == schedule_data(motion, cycles)
    modes = gait_info(motion, "made").count("]     ")
    assert modes == 2 * len(intervals(motion)) + 1
    durations = [line for line in towr_formulation(motion, cycles).splitlines() if "durations" in line]
    for line, row in zip(durations, pattern, strict=True):
        parts = [float(part) for part in line[line.index("{") + 1 : line.index("}")].split(",")]
        assert sum(parts) == pytest.approx(cycles * 0.6, abs=1e-8) and min(parts) > 0
        assert (len(parts) == 1) == (row in ("0000", "1111"))


def test_an_endless_stance_has_no_ends_in_json() -> None:
    data = schedule_data(made(SPATIAL, "1111/0110/0110/0110"))
    (stance,) = data["stances"]["LF"]
    assert (stance["start"], stance["end"]) == (None, None)


def test_who_has_no_modes() -> None:
    with pytest.raises(ValueError, match="legs LF, RF: OCS2's modes are those of a quadruped"):
        gait_info(made(PLANAR, "0110/1100"), "walk")
    with pytest.raises(ValueError, match="dimension = 2: TOWR's robots are in space"):
        towr_formulation(made(PLANAR, "0110/1100"))


def test_modes_are_called_after_the_places_of_the_legs() -> None:
    """RF and LF are swapped by name: the modes follow the names, not the order."""
    motion = trot()
    renamed = replace(motion, leg_names=("FR", "FL", "RR", "RL"))
    text = gait_info(renamed, "trot")
    assert "[0]     LF_RH\n    [1]     RF_LH" in text
    assert "[0]     RF_LH\n    [1]     LF_RH" in gait_info(motion, "trot")
