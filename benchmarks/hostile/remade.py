"""A scenario of odd numbers with the problem that it makes: as a whole consistent, and no robot's."""

from __future__ import annotations

import random
from typing import Any

import numpy as np

from benchmarks.hostile.fields import fields_of, value_at
from gaitflow.config.scenario import Scenario, digest_of
from gaitflow.problem import transcribe
from gaitflow.runtime.problem_check import problem_check_bytes, record

FACTORS = (1e-300, 1e-30, 1e-9, 1e-3, 1e3, 1e9, 1e14, 1e30)
PARTS = ("robot", "objective", "transcription", "swing_clearance")


def remade(manifest: dict[str, Any], chance: random.Random) -> tuple[dict[str, Any], bytes]:
    """The manifest with one number of its problem changed, and the problem_check.safetensors that proves it.

    Raises ValueError for a scenario that is none.
    """
    scenario = manifest["scenario"]
    places = [
        path for path in fields_of(scenario) if path[0] in PARTS and type(value_at(scenario, path)) in (int, float)
    ]
    path = chance.choice(places)
    holder = value_at(scenario, path[:-1])
    value = holder[path[-1]]
    odd = value * chance.choice(FACTORS) if value else chance.choice(FACTORS)
    holder[path[-1]] = max(1, round(value * chance.choice([0.5, 2]))) if type(value) is int else odd
    made = Scenario.from_data(scenario, "scenario")
    problem, rng = transcribe(made), np.random.default_rng(0)
    task = made.tasks.space.task({axis: values.values[0] for axis, values in made.tasks.ranges.items()})
    check = record(problem.nlp, [rng.normal(size=problem.layout.nw) for _ in range(3)], [task] * 3)
    changed = manifest | {"scenario_digest": digest_of(scenario), "cost_scale": float(problem.cost_scale)}
    return changed, problem_check_bytes(check)
