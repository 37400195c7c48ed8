"""Golden plans of the published maps: a change of the fast method shows here before any clock does.

`python tests/helpers/golden_plans.py` makes the file anew, for the newest version of every map of today's format.
"""

from __future__ import annotations

import pytest
from golden_plans import GOLDEN, SPREAD, golden, published

from gaitflow.runtime import GaitMap

PLANS = golden()


def test_every_published_map_has_golden_plans_of_its_newest_version() -> None:
    newest = {name: folder.name for name, folder in published().items()}
    recorded = {name: record["version"] for name, record in PLANS.items()}
    assert recorded == newest, f"make {GOLDEN.name} anew: python tests/helpers/golden_plans.py"


@pytest.mark.parametrize("name", sorted(PLANS))
def test_plans_take_as_few_iterations_as_when_the_map_was_published(name: str) -> None:
    gait_map = GaitMap.load(published()[name])
    for row in PLANS[name]["plans"]:
        plan = gait_map.plan(**row["task"])
        assert (plan.gait, plan.path, plan.feasible) == (row["gait"], row["path"], True), row
        assert plan.cost <= 1.0001 * row["cost"], row
        assert plan.iterations <= row["iterations"] + SPREAD, (row, plan.iterations)
