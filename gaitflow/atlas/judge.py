"""How good an atlas' predictions are: plans are started from them at random tasks that are not nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitflow.atlas.fill import LIMIT
from gaitflow.atlas.grow import Growth
from gaitflow.runtime.atlas import Atlas

TASKS = 100
TRIES = 20  # random tasks that are drawn for each one that is inside the domain
SEED = 0


@dataclass(frozen=True)
class Predictions:
    """What came of `tasks` predictions of the gait of least cost; numbers are NaN where there is nothing to average.

    converged: Newton's method reached the optimum from them, in iterations_mean and iterations_p95 iterations;
    cost_error_*: relative errors of the predicted costs of those.
    """

    tasks: int
    converged: int
    iterations_mean: float
    iterations_p95: float
    cost_error_median: float
    cost_error_p95: float


def judge_predictions(growth: Growth, atlas: Atlas, tasks: int = TASKS) -> Predictions:
    """Predictions at random tasks inside the domain. Equal atlases give equal numbers."""
    rng, sheets = np.random.default_rng(SEED), growth.numbers_of(atlas)
    low, high = ([axis[end] for axis in growth.grid] for end in (0, -1))
    drawn = (tuple(rng.uniform(low, high).tolist()) for _ in range(TRIES * tasks))
    places = [place for place in drawn if growth.inside(place)][:tasks]
    iterations, errors, asked = [], [], 0
    for place in places:
        ranked = atlas.ranked(np.array(place))
        predicted = atlas.predict(ranked[0], np.array(place)) if ranked else None
        if predicted is None:
            continue
        asked += 1
        outcome = growth.solver.refined(sheets[ranked[0]], place, predicted, LIMIT)
        if outcome.converged:
            iterations.append(outcome.iterations)
            errors.append(abs(predicted.cost / outcome.cost - 1))
    if not iterations:
        return Predictions(asked, 0, *[float("nan")] * 4)
    return Predictions(
        asked,
        len(iterations),
        float(np.mean(iterations)),
        float(np.quantile(iterations, 0.95)),
        float(np.median(errors)),
        float(np.quantile(errors, 0.95)),
    )
