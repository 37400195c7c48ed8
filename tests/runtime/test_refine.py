from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from tiny_map import TinyMap, task_of, write_map

from gaitflow.core import check
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.runtime import ArtifactError, GaitMap
from gaitflow.runtime.atlas import Atlas, Prediction
from gaitflow.runtime.attempt import Attempt, Candidate, Effort
from gaitflow.runtime.problem import Problem
from gaitflow.runtime.refine import LIMIT, Refiner
from gaitflow.solvers.options import CONVERGED

WALKING, GALLOP = 0, 1
TASK = task_of(1.27, 0.85)


@pytest.fixture
def refiner(pristine: Path) -> Refiner:
    return GaitMap.load(pristine)._solvers.refiner()


def checked(tiny: TinyMap, attempt: Attempt, task: Task) -> float:
    return check.worst(tiny.problem.scenario.as_data(), attempt.trajectory, task, attempt.pattern)


def lost_prediction(atlas: Atlas, sheet: int, place: Array) -> Prediction:
    return Prediction(1.0, np.full(atlas.sheets[sheet].space.size, 50.0))


@pytest.mark.parametrize("gait", [WALKING, GALLOP])
def test_all_ways_lead_to_one_optimum(refiner: Refiner, tiny: TinyMap, gait: int) -> None:
    task = task_of(0.43, 0.7)
    predicted, from_mean = Candidate(gait, gait), Candidate(gait, None)
    attempts = [solve(each, task) for each in (predicted, from_mean) for solve in (refiner.fast, refiner.fallback)]
    assert [attempt.method for attempt in attempts] == ["fast", "fallback"] * 2
    for attempt in attempts:
        assert attempt.refined and attempt.solver_status in CONVERGED
        assert attempt.violation == checked(tiny, attempt, task) <= 1e-6
        assert attempt.cost == pytest.approx(attempts[0].cost, rel=1e-6)
        assert attempt.pattern == tiny.starts[gait].pattern
        assert attempt.predict_ms > 0 and attempt.refine_ms > 0
    assert attempts[0].iterations < attempts[2].iterations, "a prediction is nearer than the mean"


def test_options_that_ipopt_does_not_take_are_the_maps_fault(tiny: TinyMap, tmp_path: Path) -> None:
    folder = write_map(dataclasses.replace(tiny, solver_options={"tol": 0.0}), tmp_path)
    refiner = GaitMap.load(folder)._solvers.refiner()
    with pytest.raises(
        ArtifactError, match=r"manifest\.json: solver\.options = {'tol': 0\.0}: IPOPT does not take these"
    ):
        refiner.fallback(Candidate(WALKING, None), TASK)


def test_nodes_nearby_help_where_the_prediction_misleads(
    refiner: Refiner, tiny: TinyMap, monkeypatch: pytest.MonkeyPatch
) -> None:
    good = refiner.fast(Candidate(GALLOP, 1), TASK)
    monkeypatch.setattr(Atlas, "predict", lost_prediction)
    attempt = refiner.fast(Candidate(GALLOP, 1), TASK)
    assert attempt.refined and attempt.method == "fast"
    assert checked(tiny, attempt, TASK) <= 1e-6
    assert attempt.cost == pytest.approx(good.cost, rel=1e-6)


def mislead(tiny: TinyMap, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither the atlas' predictions nor its nodes lead anywhere."""
    monkeypatch.setattr(Atlas, "predict", lost_prediction)
    wrong = [lost_prediction(tiny.atlas, 1, TASK)]
    monkeypatch.setattr(Atlas, "nearest", lambda *arguments: wrong)


def test_the_nominal_start_helps_where_the_atlas_misleads(
    refiner: Refiner, tiny: TinyMap, monkeypatch: pytest.MonkeyPatch
) -> None:
    good = refiner.fast(Candidate(GALLOP, 1), TASK)
    mislead(tiny, monkeypatch)
    attempt = refiner.fast(Candidate(GALLOP, 1), TASK)
    assert attempt.refined and attempt.method == "fast"
    assert attempt.cost == pytest.approx(good.cost, rel=1e-6)
    assert not refiner.fast(Candidate(GALLOP, 1), TASK, Effort.RIVAL).refined, "a rival has not so many starts"


def test_what_no_try_solves_is_told_as_it_is(refiner: Refiner, tiny: TinyMap, monkeypatch: pytest.MonkeyPatch) -> None:
    mislead(tiny, monkeypatch)
    monkeypatch.setattr(Problem, "nominal", lambda problem, task: np.full(tiny.problem.layout.nw, 50.0))
    attempt = refiner.fast(Candidate(GALLOP, 1), TASK)
    assert not attempt.refined and attempt.solver_status == "not converged"
    assert not attempt.feasible and attempt.violation == checked(tiny, attempt, TASK)
    rescued = refiner.fallback(Candidate(GALLOP, 1), TASK)
    assert rescued.refined and checked(tiny, rescued, TASK) <= 1e-6, "IPOPT starts at the mean of the region, too"


def test_a_converged_motion_that_the_check_refuses_is_not_refined(
    refiner: Refiner, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(check, "worst", lambda *arguments: 2e-6)
    for solve in (refiner.fast, refiner.fallback):
        attempt = solve(Candidate(GALLOP, 1), TASK)
        assert attempt.solver_status in CONVERGED
        assert not attempt.feasible and not attempt.refined


def test_a_gait_has_one_matrix_however_it_came_to_be_asked(refiner: Refiner) -> None:
    first = refiner.method(Candidate(GALLOP, 1))
    assert refiner.method(Candidate(GALLOP, 1)) is first
    assert refiner.method(Candidate(GALLOP, None)) is not first
    assert refiner.fast(Candidate(GALLOP, 1), TASK).iterations <= LIMIT


def test_what_a_gait_may_cost_at_the_least_is_near_what_it_costs(refiner: Refiner) -> None:
    predicted, from_mean = Candidate(GALLOP, 1), Candidate(GALLOP, None)
    least, unknown = refiner.least([predicted, from_mean], TASK)
    assert 0.5 * refiner.fast(predicted, TASK).cost < least < 1.01 * refiner.fast(predicted, TASK).cost
    assert unknown == np.inf
