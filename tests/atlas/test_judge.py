"""Numbers of predictions at tasks that are no nodes."""

from __future__ import annotations

import math

from gaitflow.atlas.compress import build_atlas
from gaitflow.atlas.grow import Growth
from gaitflow.atlas.judge import judge_predictions
from gaitflow.runtime.atlas import Atlas


def test_predictions_of_a_real_atlas_lead_to_the_optimum(grown: Growth) -> None:
    atlas = build_atlas(grown, [0, 1], 10**9)
    found = judge_predictions(grown, atlas, 20)
    assert found == judge_predictions(grown, atlas, 20)
    assert found.tasks == 20
    assert found.converged >= 17
    assert 3 < found.iterations_mean < 10 and found.iterations_p95 <= 18
    assert found.cost_error_median < 0.02 and found.cost_error_median <= found.cost_error_p95


def test_an_atlas_that_knows_nothing_has_no_numbers(grown: Growth) -> None:
    found = judge_predictions(grown, Atlas.empty(tuple(grown.domain.axes)), 5)
    assert (found.tasks, found.converged) == (0, 0)
    assert math.isnan(found.iterations_mean)
