"""The whole training: chosen by folds alone, the same every time, and clear about maps that cannot be learnt."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import onnxruntime
import pandas as pd
import pytest
from surfaces import BOUND, GALLOP, GRADIENTS, WALK, cost_surfaces

from gaitflow.config.scenario import Learning
from gaitflow.core.domain import Domain
from gaitflow.learn.classifier import CannotTrain
from gaitflow.learn.train import KnownCosts, Training, train
from gaitflow.runtime.atlas import Atlas, Sheet

AXES = ("speed", "cycle_duration")
Frames = tuple[pd.DataFrame, pd.DataFrame]


def without(frame: pd.DataFrame, split: str) -> pd.DataFrame:
    return frame[frame["split"] != split].reset_index(drop=True)


def probabilities(model: bytes, tasks: pd.DataFrame) -> np.ndarray:
    session = onnxruntime.InferenceSession(model, providers=["CPUExecutionProvider"])
    (found,) = session.run(None, {"task": tasks[["speed", "cycle_duration"]].to_numpy(np.float32)})
    return np.asarray(found)


def test_the_published_model_knows_the_map(training: Training, synthetic_map: Frames) -> None:
    labels, _ = synthetic_map
    solved = labels[(labels["status"] == "solved") & (labels["split"] == "held_out")]
    picks = [training.classes[i] for i in probabilities(training.onnx, solved).argmax(axis=1)]
    accuracy = np.mean(solved["label"].to_numpy() == np.array(picks, dtype=object))
    assert accuracy == pytest.approx(training.winner.held_out.accuracy)
    assert accuracy > 0.8


def test_all_methods_are_judged_on_folds_and_off_the_grid(training: Training, synthetic_map: Frames) -> None:
    labels, _ = synthetic_map
    solved = labels[labels["status"] == "solved"]
    assert [row.method for row in training.competitors] == ["mlp", "svm", "forest", "knn"]
    for row in training.competitors:
        assert row.cross_validation.tasks == (solved["split"] == "grid").sum()
        assert row.held_out.tasks == (solved["split"] == "held_out").sum()
        assert row.cross_validation.accuracy > 0.8
    assert training.tasks_per_gait == tuple(solved[solved["split"] == "grid"].groupby("label").size())
    assert [sum(row) for row in training.confusion] == list(training.tasks_per_gait)
    right = sum(training.confusion[i][i] for i in range(len(training.classes)))
    assert right / sum(training.tasks_per_gait) == pytest.approx(training.winner.cross_validation.accuracy)


def test_training_twice_gives_the_same_bytes_also_when_a_constant_map_would_do(
    training: Training, synthetic_map: Frames, learning: Learning
) -> None:
    again = train(*synthetic_map, AXES, learning, constant=True)
    assert again.onnx == training.onnx
    assert again.as_data() == training.as_data()


def test_held_out_tasks_change_the_report_and_nothing_else(
    training: Training, synthetic_map: Frames, learning: Learning
) -> None:
    labels, costs = synthetic_map
    alone = train(without(labels, "held_out"), without(costs, "held_out"), AXES, learning)
    assert alone.onnx == training.onnx
    assert alone.winner.cross_validation == training.winner.cross_validation
    assert alone.winner.held_out.tasks == 0
    assert alone.as_data()["competitors"][0]["held_out"]["accuracy"] is None


def test_the_record_is_json_with_the_rule_and_without_the_model(training: Training) -> None:
    data = json.loads(json.dumps(training.as_data(), allow_nan=False))
    assert "cross-validation folds only" in data["rule"]
    assert data["method"] == training.method
    assert data["classes"] == list(training.classes)
    assert "onnx" not in data


def constant_frames(synthetic_map: Frames) -> Frames:
    labels, costs = synthetic_map
    walking = labels["label"] == "walking"
    return labels[walking | (labels["status"] == "infeasible")], costs


def test_a_map_of_one_gait_is_refused_with_the_way_out(synthetic_map: Frames, learning: Learning) -> None:
    labels, costs = constant_frames(synthetic_map)
    with pytest.raises(CannotTrain, match=r"all \d+ feasible tasks have the gait 'walking'.*--constant"):
        train(labels, costs, AXES, learning)


def test_a_constant_map_is_published_when_asked(synthetic_map: Frames, learning: Learning) -> None:
    labels, costs = constant_frames(synthetic_map)
    constant = train(labels, costs, AXES, learning, constant=True)
    assert (constant.method, constant.classes) == ("constant", ("walking",))
    np.testing.assert_array_equal(probabilities(constant.onnx, labels), np.ones((len(labels), 1)))
    assert constant.winner.held_out.accuracy == 1.0
    assert "nothing was learnt" in constant.as_data()["remarks"][0]


@pytest.mark.parametrize("constant", [False, True])
def test_a_map_without_a_feasible_task_is_refused(synthetic_map: Frames, learning: Learning, constant: bool) -> None:
    labels, costs = synthetic_map
    infeasible = labels[labels["status"] == "infeasible"]
    for split in ("grid", "sampled"):
        with pytest.raises(CannotTrain, match=rf"none of the {len(infeasible)} tasks of the map has a feasible gait"):
            train(infeasible.assign(split=split), costs, AXES, learning, constant=constant)


def test_a_gait_of_a_single_task_is_learnt_and_said(synthetic_map: Frames, learning: Learning) -> None:
    labels, costs = synthetic_map
    rare = labels.copy()
    rare.at[0, "label"] = "a hop"
    found = train(rare, costs, AXES, learning)
    assert found.classes[0] == "a hop"
    assert any("never tested: a hop" in remark for remark in found.remarks)
    assert found.tasks_per_gait[0] == 1
    assert sum(found.confusion[0]) == 0


def test_a_task_out_of_scale_gets_a_probability_all_the_same(training: Training) -> None:
    far = pd.DataFrame({"speed": [0.0, 1e3], "cycle_duration": [1e-3, 1e3]})
    found = probabilities(training.onnx, far)
    assert np.isfinite(found).all()
    np.testing.assert_allclose(found.sum(axis=1), 1.0, atol=1e-5)


def known_costs() -> KnownCosts:
    """An atlas of the synthetic map whose nodes lie on its grid, with a gait that the map does not have."""
    speeds, durations = np.linspace(0.1, 2.3, 8), np.linspace(0.4, 1.6, 6)
    gaits = {"walking": WALK, "gallop": GALLOP, "bounding": BOUND}
    sheets = []
    for number, key in enumerate(gaits.values()):
        places = [(v, t) for v in speeds for t in durations if key in cost_surfaces(v, t)]
        costs = np.array([cost_surfaces(*place)[key] for place in places])
        slopes = np.array([GRADIENTS[key] for _ in places]) / costs[:, None]
        sheets.append(
            Sheet(
                gait=number,
                pattern="",
                space=None,  # type: ignore[arg-type]  # costs do not ask for it
                tasks=np.array(places),
                costs=costs,
                slopes=slopes,
                mean=np.zeros(1, np.float32),
                modes=np.zeros((1, 1), np.float32),
                coordinates=np.zeros((len(places), 1), np.float32),
                tangents=np.zeros((len(places), 2, 1), np.float32),
                tear=1.0,
                infeasible=np.zeros((0, 2)),
            )
        )
    steps = np.array([speeds[1] - speeds[0], durations[1] - durations[0]])
    feasible = np.array([[bool(cost_surfaces(v, t)) for t in durations] for v in speeds])
    domain = Domain({"speed": tuple(speeds.tolist()), "cycle_duration": tuple(durations.tolist())}, feasible)
    return KnownCosts(Atlas(AXES, steps, 1e-4, tuple(sheets)), tuple(gaits), domain)


def test_the_atlas_refines_the_published_model_and_takes_no_part_in_choosing(
    training: Training, synthetic_map: Frames, learning: Learning
) -> None:
    found = train(*synthetic_map, AXES, learning, known=known_costs())
    assert training.published.atlas_tasks == 0 and found.published.atlas_tasks > 200
    before, after = training.as_data(), found.as_data()
    assert before.pop("published") != after.pop("published")
    assert before == after
    assert found.onnx != training.onnx
    tasks = pd.DataFrame(np.random.default_rng(5).uniform((0.1, 0.4), (2.3, 1.3), (600, 2)), columns=list(AXES))
    best = [min(cost_surfaces(v, t).items(), key=lambda item: item[1])[0] for v, t in tasks.to_numpy()]
    name = {WALK: "walking", GALLOP: "gallop", BOUND: "bounding"}
    truth = np.array([found.classes.index(name[key]) for key in best])
    right = [np.mean(probabilities(each.onnx, tasks).argmax(axis=1) == truth) for each in (training, found)]
    assert right[1] > max(right[0], 0.95)


def test_what_the_map_picks_is_judged_beside_the_classifier(synthetic_map: Frames, learning: Learning) -> None:
    found = train(*synthetic_map, AXES, learning, known=known_costs()).published
    assert found.map_held_out.tasks == found.held_out.tasks
    assert found.map_held_out.accuracy == 1.0, "surfaces this smooth are predicted exactly"
    assert found.map_held_out.regret_mean == pytest.approx(0.0, abs=1e-6)


def test_without_an_atlas_the_classifier_picks(training: Training) -> None:
    assert training.published.map_held_out == training.published.held_out


def test_an_atlas_that_knows_nothing_changes_nothing(
    training: Training, synthetic_map: Frames, learning: Learning
) -> None:
    known = known_costs()
    found = train(*synthetic_map, AXES, learning, known=replace(known, atlas=Atlas.empty(AXES)))
    assert found.onnx == training.onnx
    assert found.as_data() == training.as_data()


def test_an_atlas_over_many_axes_labels_nothing(
    training: Training, synthetic_map: Frames, learning: Learning, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Atlas, "is_wide", True)
    found = train(*synthetic_map, AXES, learning, known=known_costs())
    assert found.onnx == training.onnx and found.published.atlas_tasks == 0


def test_the_order_of_the_tasks_does_not_matter(training: Training, synthetic_map: Frames, learning: Learning) -> None:
    labels, costs = (frame.sample(frac=1.0, random_state=7, ignore_index=True) for frame in synthetic_map)
    found = train(labels, costs, AXES, learning)
    assert found.onnx == training.onnx and found.as_data() == training.as_data()


def test_one_axis_is_enough(synthetic_map: Frames, learning: Learning) -> None:
    labels, costs = (frame[np.isclose(frame["cycle_duration"], 0.64)] for frame in synthetic_map)
    found = train(labels.reset_index(drop=True), costs.reset_index(drop=True), ("speed",), learning)
    session = onnxruntime.InferenceSession(found.onnx, providers=["CPUExecutionProvider"])
    (slow, fast) = session.run(None, {"task": np.array([[0.2], [2.0]], dtype=np.float32)})[0]
    assert found.classes[slow.argmax()] == "walking" and found.classes[fast.argmax()] == "gallop"
