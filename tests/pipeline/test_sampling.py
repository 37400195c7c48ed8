"""An adaptive map from its first task to its certificate, stopped and gone on with on the way."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from gaitflow.runtime import GaitMap

SCENARIO = """\
name: adaptive-small
robot: half_cheetah
objective: {tangential_velocity: 1.0e+6, normal_velocity: 1.0e+6, tilt: 1.0e+6, tilt_rate: 1.0e+6}
transcription: {knots_per_phase: 6, integrator: momentum, forces: linear, grading: 1.0}
tasks:
  axes: {speed: {start: 0.3, stop: 1.5, count: 4}, cycle_duration: {start: 0.4, stop: 0.8, count: 3}}
  sampling: {start: 6, each: 3, most: 60, dearer: 0.2, infeasible: 0.1}
strategy: {name: patterns, restarts: 1}
learning: {methods: [knn]}
limits: {regret_mean: 0.5}
"""


def gaitflow(folder: Path, *arguments: str) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "gaitflow.cli", *arguments], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def read(path: Path) -> Any:
    return json.loads(path.read_text())


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_map_chooses_its_tasks_until_it_is_certified(tmp_path: Path) -> None:
    (tmp_path / "small.yaml").write_text(SCENARIO)
    gaitflow(tmp_path, "solve", "small.yaml")
    run = tmp_path / "runs" / "adaptive-small"
    rounds, record = read(run / "sampling" / "rounds.json"), read(run / "sampling" / "sampling.json")
    assert [one["kind"] for one in rounds[:2]] == ["start", "doubt"]
    assert record["certificate"]["dearer_bound"] <= 0.2 and record["certificate"]["infeasible_bound"] <= 0.1
    assert record["curve"][-1]["kind"] in ("certificate", "more")

    before = (run / "sampling" / "atlas.safetensors").read_bytes()
    (run / "sampling" / "rounds.json").write_text(json.dumps(rounds[:2]))  # as if it had been stopped after two
    solved = set((run / "units").iterdir()) if (run / "units").is_dir() else set()
    gaitflow(tmp_path, "solve", "small.yaml")
    assert read(run / "sampling" / "rounds.json") == rounds, "the same tasks again"
    assert (run / "sampling" / "atlas.safetensors").read_bytes() == before
    assert not solved or set((run / "units").iterdir()) == solved, "none of them was searched again"
    status = gaitflow(tmp_path, "status", "small.yaml")
    tasks = sum(len(one["tasks"]) for one in rounds)
    assert f"{tasks} units: {tasks} solved, 0 failed, 0 left" in status

    for stage in ("label", "atlas", "train", "publish", "report"):
        gaitflow(tmp_path, stage, "small.yaml")
    labels = pq.read_table(run / "labels.parquet").to_pandas()
    drawn = record["certificate"]["searched"]
    assert (labels["split"] == "held_out").sum() == drawn and (labels["split"] == "sampled").sum() == tasks - drawn
    gait_map = GaitMap.load(tmp_path / "models" / "adaptive-small")
    certificate = gait_map.manifest.metrics["certificate"]
    assert certificate == record["certificate"]
    held_out = labels[labels["split"] == "held_out"]
    picks = [gait_map.select(row.speed, row.cycle_duration).gait for row in held_out.itertuples()]
    wrong = sum(pick not in ties for pick, ties in zip(picks, held_out["ties"], strict=True))
    assert wrong <= max(certificate["dearer"], 2), "the published map picks what was judged"
    card = (tmp_path / "models" / "adaptive-small" / "1.0.0" / "README.md").read_text()
    assert "## Certificate" in card and f"**{certificate['dearer_bound']:.2%}**" in card
    html = (run / "report" / "index.html").read_text(encoding="utf-8")
    assert "<h2>Certificate</h2>" in html and f"<b>{tasks - drawn}</b><span>searched tasks</span>" in html

    traced = json.loads(
        gaitflow(tmp_path, "trace", "models/adaptive-small", "--speed", "0.9", "--cycle", "0.6", "--json")
    )
    searched = labels[(labels["split"] == "sampled") & (labels["status"] == "solved")]
    places = searched[["speed", "cycle_duration"]].to_numpy()
    away = np.linalg.norm((places - [0.9, 0.6]) / np.ptp(places, axis=0), axis=1)
    nearest = searched.iloc[int(away.argmin())]
    assert traced["decision"]["task"] == {axis: nearest[axis] for axis in ("speed", "cycle_duration")}
    assert traced["decision"]["solves"][0]["gait"] == nearest["gait"]
    assert list((run / "units").rglob(f"*{traced['decision']['unit']}*")), "the unit that searched it"

    asked = json.loads(gaitflow(tmp_path, "certify", "models/adaptive-small", "--tasks", "6", "--seed", "9", "--json"))
    assert asked["searched"] == 6 and asked["planned"] >= 6 and asked["dearer"] <= 2
    assert np.isclose(asked["dearer_bound"], 1.0) or asked["dearer_bound"] < 0.9

    refined = tmp_path / "refined"
    refined.mkdir()
    (refined / "small.yaml").write_text(SCENARIO.replace("most: 60", f"most: {tasks}"))
    begin = ("--begin", str(tmp_path / "datasets" / "adaptive-small"), "--map", str(tmp_path / "models/adaptive-small"))
    gaitflow(refined, "solve", "small.yaml", *begin)
    again = read(refined / "runs" / "adaptive-small" / "sampling" / "sampling.json")
    assert all(again["nodes"][sheet] >= number for sheet, number in record["nodes"].items())
    assert again["solves"] < record["solves"] / 2, "its nodes are solved again, and not grown"
    gaitflow(refined, "solve", "small.yaml")  # goes on, with the nodes that it began with


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_sampling_begins_from_the_searches_of_a_stopped_one(tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    for folder, most in ((first, 4), (second, 9)):
        folder.mkdir()
        (folder / "small.yaml").write_text(SCENARIO.replace("most: 60", f"most: {most}"))
    gaitflow(first, "solve", "small.yaml")
    assert "datasets/adaptive-small/1.0.0" in gaitflow(first, "datasets", "publish", "small.yaml")
    assert gaitflow(first, "verify", "datasets/adaptive-small")
    begun = read(first / "runs" / "adaptive-small" / "sampling" / "rounds.json")[0]["tasks"]

    begin = ("solve", "small.yaml", "--begin", str(first / "datasets" / "adaptive-small"))
    gaitflow(second, *begin)
    run = second / "runs" / "adaptive-small"
    rounds = read(run / "sampling" / "rounds.json")
    assert [one["kind"] for one in rounds] == ["known", "start", "doubt"]
    assert sorted(rounds[0]["tasks"]) == sorted(begun) and len(rounds[1]["tasks"]) == 2, "what the start lacked"
    assert sum(len(one["tasks"]) for one in rounds) == 9, "what it began from counts towards the most"
    assert read(run / "sampling" / "sampling.json")["certificate"] is None
    gaitflow(second, *begin)
    assert read(run / "sampling" / "rounds.json") == rounds, "the same command goes on"
    (run / "sampling" / "rounds.json").write_text(json.dumps(rounds[1:]))
    done = subprocess.run(
        [sys.executable, "-m", "gaitflow.cli", *begin], cwd=second, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2 and "has begun already, and not from this dataset" in done.stderr


def test_a_box_without_a_motion_is_one_line(tmp_path: Path) -> None:
    nowhere = SCENARIO.replace("{start: 0.3, stop: 1.5, count: 4}", "{start: 18.0, stop: 19.0, count: 2}")
    (tmp_path / "small.yaml").write_text(nowhere.replace("start: 6, each: 3, most: 60", "start: 2, each: 1, most: 4"))
    done = subprocess.run(
        [sys.executable, "-m", "gaitflow.cli", "solve", "small.yaml"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 1 and "Traceback" not in done.stderr
    assert "none of the 2 tasks that were searched has a motion" in done.stderr.splitlines()[-1]


TURNING = """\
name: turning-small
robot: anymal
objective: {force: 1.0e-2, tangential_velocity: 1.0e+6, normal_velocity: 1.0e+6, tilt: 1.0e+6, tilt_rate: 1.0e+6}
transcription: {knots_per_phase: 4, min_phase_fraction: 0.2}
stances_per_leg: 1
tasks:
  axes: {speed: 0.5, yaw_rate: {start: -0.8, stop: 0.8, count: 3}, cycle_duration: {start: 0.5, stop: 0.7, count: 2}}
  sampling: {start: 3, each: 2, most: 20, dearer: 0.6, infeasible: 0.6}
strategy: {name: guided, restarts: 1, budget: 12}
learning: {methods: [knn]}
limits: {regret_mean: 1.0}
"""


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_map_that_is_its_own_image_learns_twice_from_a_search(tmp_path: Path) -> None:
    (tmp_path / "small.yaml").write_text(TURNING)
    for stage in ("solve", "label", "atlas", "train"):
        gaitflow(tmp_path, stage, "small.yaml")
    gaitflow(tmp_path, "publish", "small.yaml", "--force")
    run = tmp_path / "runs" / "turning-small"
    rounds = read(run / "sampling" / "rounds.json")
    searched = sum(len(one["tasks"]) for one in rounds if one["kind"] in ("start", "doubt"))
    rows = pq.read_table(run / "solutions.parquet").to_pandas()
    made_from = rows[rows["split"] == "sampled"]
    images = made_from[made_from["start"] == "mirror image"]
    assert len(made_from[["yaw_rate", "cycle_duration"]].drop_duplicates()) == 2 * searched
    assert len(images) == len(made_from) / 2 and not images["solves"].any()
    solved = made_from[made_from["start"] != "mirror image"]
    assert sorted(images["cost"].dropna()) == sorted(solved["cost"].dropna())
    gait_map = GaitMap.load(tmp_path / "models" / "turning-small")
    for yaw_rate, cycle in ((0.3, 0.55), (0.7, 0.65)):
        left, right = (gait_map.plan(yaw_rate=way * yaw_rate, cycle_duration=cycle) for way in (1, -1))
        assert left.feasible and right.feasible and right.cost == pytest.approx(left.cost, rel=1e-3)


EVERYWHERE = SCENARIO.replace("name: adaptive-small", "name: wide-small").replace(
    "cycle_duration: {start: 0.4, stop: 0.8, count: 3}}",
    "cycle_duration: {start: 0.4, stop: 0.8, count: 3}, slope: {start: -10.0, stop: 10.0, count: 3}, "
    "friction: {start: 0.4, stop: 0.8, count: 2}}",
)


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_over_four_axes_a_published_map_plans_as_it_was_certified(tmp_path: Path) -> None:
    (tmp_path / "small.yaml").write_text(EVERYWHERE.replace("dearer: 0.2", "dearer: 0.4").replace("each: 3", "each: 2"))
    for stage in ("solve", "label", "atlas", "train"):
        gaitflow(tmp_path, stage, "small.yaml")
    gaitflow(tmp_path, "publish", "small.yaml", "--force")  # so small a map is beyond its scenario's limits
    gait_map = GaitMap.load(tmp_path / "models" / "wide-small")
    certificate = gait_map.manifest.metrics["certificate"]
    assert certificate["learning"] is not None, "its plans asked a classifier, as those of the published map do"

    axes = tuple(gait_map.manifest.domain.axes)
    assert len(axes) == 4
    labels = pq.read_table(tmp_path / "runs" / "wide-small" / "labels.parquet").to_pandas()
    drawn = labels[(labels["split"] == "held_out") & (labels["status"] == "solved")]
    assert len(drawn) == certificate["searched"]
    plans = [gait_map.plan(**{axis: getattr(row, axis) for axis in axes}) for row in drawn.itertuples()]
    assert all(plan.feasible for plan in plans)
    dearer = [plan.cost > 1.01 * cost for plan, cost in zip(plans, drawn["cost"], strict=True)]
    assert sum(dearer) == certificate["dearer"]
