"""The whole training: chosen by folds alone, the same every time, and clear about maps that cannot be learnt."""

from __future__ import annotations

import json

import numpy as np
import onnxruntime
import pandas as pd
import pytest

from gaitflow.config.scenario import Learning
from gaitflow.learn.classifier import CannotTrain
from gaitflow.learn.nodes import NodeLabels
from gaitflow.learn.train import Training, train

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
    again = train(*synthetic_map, learning, constant=True)
    assert again.onnx == training.onnx
    assert again.as_data() == training.as_data()


def test_held_out_tasks_change_the_report_and_nothing_else(
    training: Training, synthetic_map: Frames, learning: Learning
) -> None:
    labels, costs = synthetic_map
    alone = train(without(labels, "held_out"), without(costs, "held_out"), learning)
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
        train(labels, costs, learning)


def test_a_constant_map_is_published_when_asked(synthetic_map: Frames, learning: Learning) -> None:
    labels, costs = constant_frames(synthetic_map)
    constant = train(labels, costs, learning, constant=True)
    assert (constant.method, constant.classes) == ("constant", ("walking",))
    np.testing.assert_array_equal(probabilities(constant.onnx, labels), np.ones((len(labels), 1)))
    assert constant.winner.held_out.accuracy == 1.0
    assert "nothing was learnt" in constant.as_data()["remarks"][0]


@pytest.mark.parametrize("constant", [False, True])
def test_a_map_without_a_feasible_task_is_refused(synthetic_map: Frames, learning: Learning, constant: bool) -> None:
    labels, costs = synthetic_map
    infeasible = labels[labels["status"] == "infeasible"]
    with pytest.raises(CannotTrain, match=r"none of the \d+ tasks of the grid has a feasible gait"):
        train(infeasible, costs, learning, constant=constant)


def test_a_gait_of_a_single_task_is_learnt_and_said(synthetic_map: Frames, learning: Learning) -> None:
    labels, costs = synthetic_map
    rare = labels.copy()
    rare.at[0, "label"] = "a hop"
    found = train(rare, costs, learning)
    assert found.classes[0] == "a hop"
    assert any("never tested: a hop" in remark for remark in found.remarks)
    assert found.tasks_per_gait[0] == 1
    assert sum(found.confusion[0]) == 0


def test_a_task_out_of_scale_gets_a_probability_all_the_same(training: Training) -> None:
    far = pd.DataFrame({"speed": [0.0, 1e3], "cycle_duration": [1e-3, 1e3]})
    found = probabilities(training.onnx, far)
    assert np.isfinite(found).all()
    np.testing.assert_allclose(found.sum(axis=1), 1.0, atol=1e-5)


def nodes_of(cells: int) -> tuple[NodeLabels, list[str]]:
    """Labels of 600 tasks amid the grid, cut into so many cells, seven of them of a gait that the map does not have."""
    tasks = np.random.default_rng(5).uniform((0.1, 0.4), (2.3, 1.3), (600, 2))
    gaits = np.where(1.0 + 2.0 * tasks[:, 0] < 1.8 + tasks[:, 0], 1, 0)
    gaits[:7] = 2
    return NodeLabels(tasks.astype(np.float32), gaits, np.arange(600) % cells), ["gallop", "walking", "limping"]


def test_nodes_refine_the_published_model_and_take_no_part_in_choosing(
    training: Training, synthetic_map: Frames, learning: Learning
) -> None:
    nodes, gaits = nodes_of(cells=20)
    found = train(*synthetic_map, learning, nodes=(nodes, gaits))
    assert training.published.nodes == 0 and found.published.nodes == 593, "of gaits that the map does not have none"
    before, after = training.as_data(), found.as_data()
    assert before.pop("published") != after.pop("published")
    assert before == after
    assert found.onnx != training.onnx
    tasks = pd.DataFrame(nodes.tasks[7:], columns=["speed", "cycle_duration"])
    truth = np.array([found.classes.index(gaits[n]) for n in nodes.gaits[7:]])
    right = [np.mean(probabilities(each.onnx, tasks).argmax(axis=1) == truth) for each in (training, found)]
    assert right[1] > max(right[0], 0.97)


def test_nodes_of_one_cell_leave_the_temperature_as_it_was(
    training: Training, synthetic_map: Frames, learning: Learning
) -> None:
    found = train(*synthetic_map, learning, nodes=nodes_of(cells=1))
    assert found.published.temperature == training.published.temperature
    assert found.as_data()["published"]["log_loss"] is None
