"""The document of a certificate: every judged task by names, and a plan that is missing as null."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.document import plain
from benchmarks.online.certify import row, run, summarise
from gaitflow.certificate.certificate import certify
from gaitflow.certificate.judge import INFEASIBLE, Verdict
from gaitflow.core.task import Task
from gaitflow.pipeline.workspace import Workspace
from gaitflow.runtime import GaitMap

MAP = Path(__file__).parents[3] / "models" / "half-cheetah-exact-vibration"


def test_judged_plans_are_told_by_names() -> None:
    gait_map = GaitMap.load(MAP)
    one, other = gait_map.gaits[:2]
    task = Task.of({"speed": 0.9, "cycle_duration": 0.6})
    verdicts = [Verdict(task, one.key, other.key, 0.02), Verdict(task, one.key, one.key, -0.01)]
    verdicts.append(Verdict(task, one.key, "1/1", INFEASIBLE))
    rows = [plain(row(verdict, gait_map)) for verdict in verdicts]
    assert rows[0] == {"speed": 0.9, "cycle_duration": 0.6, "gait": one.name, "best": other.name, "excess": 0.02}
    assert rows[2]["excess"] is None and rows[2]["best"] == "1/1", "a gait that the map does not have"

    summary = summarise(certify(verdicts, verdicts, [True], 1, 7), verdicts, gait_map)
    assert summary["version"] == str(gait_map.manifest.version) and summary["same_gait"] == 1
    assert (summary["dearer"], summary["searched"], summary["infeasible"], summary["planned"]) == (2, 3, 1, 4)


@pytest.mark.slow
def test_a_published_map_is_judged(tmp_path: Path) -> None:
    done = run(Workspace(tmp_path), MAP, 2, 0)
    assert done["summary"]["searched"] == len(done["rows"]) == 2 and done["summary"]["planned"] > 1000
    assert done["summary"]["infeasible"] == 0, "all of them have a plan"
    assert all(each["excess"] < 1.0 for each in done["rows"])
