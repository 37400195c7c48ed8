from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import load, save
from tiny_map import TinyMap, task_of

import gaitflow
from gaitflow.core.task import AXES
from gaitflow.problem import GaitProblem
from gaitflow.runtime import ArtifactError, GaitMap
from gaitflow.runtime.files import PROBLEM_CHECK, entry_of
from gaitflow.runtime.manifest import encode
from gaitflow.runtime.problem_check import ProblemCheck, parse_problem_check, problem_check_bytes, record


@pytest.fixture(scope="module")
def stored(tiny: TinyMap) -> ProblemCheck:
    rng = np.random.default_rng(3)
    points = [start.primal for start in tiny.starts] + [rng.normal(size=tiny.problem.layout.nw)]
    return record(tiny.problem.nlp, points, [task_of(v, 0.6) for v in (0.3, 1.3, 0.9)])


def parse(content: bytes, problem: GaitProblem) -> ProblemCheck:
    return parse_problem_check(content, problem.layout, problem.ng, "c")


def rewritten(artifact: Path, **scenario: object) -> None:
    """The artifact with parts of its scenario replaced, and every digest made anew."""
    data = json.loads((artifact / "manifest.json").read_text())
    data["scenario"] |= scenario
    data["files"][PROBLEM_CHECK] = asdict(entry_of((artifact / PROBLEM_CHECK).read_bytes()))
    (artifact / "manifest.json").write_bytes(encode(data))


def test_what_was_written_is_read_and_equals_the_problem(tiny: TinyMap, stored: ProblemCheck) -> None:
    found = parse(problem_check_bytes(stored), tiny.problem)
    for name, value in asdict(stored).items():
        np.testing.assert_array_equal(getattr(found, name), value)
    assert found.differs(tiny.problem.nlp) is None


def test_an_axis_that_did_not_exist_then_has_its_default(tiny: TinyMap, stored: ProblemCheck) -> None:
    older = replace(
        stored,
        axes=("speed", "cycle_duration"),
        tasks=stored.tasks[:, [list(AXES).index("speed"), list(AXES).index("cycle_duration")]],
    )
    assert older.differs(tiny.problem.nlp) is None
    assert replace(older, tasks=older.tasks + 0.1).differs(tiny.problem.nlp) is not None


@pytest.mark.parametrize(("name", "said"), [("costs", "the cost at point 0"), ("rows", "a row at point 0")])
@pytest.mark.parametrize("off", [1e-7, np.nan])
def test_the_smallest_difference_is_said(tiny: TinyMap, stored: ProblemCheck, name: str, said: str, off: float) -> None:
    changed = replace(stored, **{name: getattr(stored, name) + off})
    assert said in changed.differs(tiny.problem.nlp)
    near = replace(stored, **{name: getattr(stored, name) * (1 + 1e-11)})
    assert near.differs(tiny.problem.nlp) is None


def test_another_number_of_rows_is_said(tiny: TinyMap, stored: ProblemCheck) -> None:
    assert "rows instead of" in replace(stored, rows=stored.rows[:, 1:]).differs(tiny.problem.nlp)


def test_a_scenario_that_makes_another_problem_names_both_versions(artifact: Path) -> None:
    objective = GaitMap.load(artifact).manifest.scenario["objective"]
    rewritten(artifact, objective={**objective, "tilt": 1.0})
    gait_map = GaitMap.load(artifact)
    assert gait_map.select(0.9, 0.6).gait is not None
    with pytest.raises(ArtifactError) as caught:
        gait_map.plan(0.9, 0.6)
    said = str(caught.value)
    assert f"gaitflow {gaitflow.__version__}, which is installed" in said and "gaitflow 0.0.9 made" in said
    assert "the cost at point" in said


def test_a_scenario_that_is_none_any_more_is_refused(artifact: Path) -> None:
    rewritten(artifact, objective={"force": 0.0})
    with pytest.raises(ArtifactError, match=r"objective.*published by gaitflow 0\.0\.9"):
        GaitMap.load(artifact).plan(0.9, 0.6)


@pytest.mark.parametrize("name", ["axes", "w", "tasks", "costs", "rows"])
@pytest.mark.parametrize("oddity", ["missing", "type", "shorter", "not finite"])
def test_odd_tensors_are_refused(tiny: TinyMap, stored: ProblemCheck, name: str, oddity: str) -> None:
    tensors = load(problem_check_bytes(stored))
    tensor = tensors.pop(name)
    if oddity == "type":
        tensors[name] = tensor.astype(np.float16)
    if oddity == "shorter":
        tensors[name] = tensor[:-1].copy()
    if oddity == "not finite":
        tensors[name] = np.full_like(tensor, 0 if name == "axes" else np.nan)
    with pytest.raises(ArtifactError, match=r"^c: "):
        parse(save(tensors), tiny.problem)


def test_a_task_that_is_none_is_refused(tiny: TinyMap, stored: ProblemCheck) -> None:
    with pytest.raises(ArtifactError, match="tasks holds one that is none: speed = 1000"):
        parse(problem_check_bytes(replace(stored, tasks=stored.tasks + 1000.0)), tiny.problem)
