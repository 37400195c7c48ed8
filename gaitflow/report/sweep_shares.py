"""For how many robots of a sweep each statement of the paper holds, and which parameters decide it.

A verdict counts 0 (does not), 1 (holds in part) or 2 (holds), and what decides it is looked for by Spearman's rank
correlation with each parameter. Its p is the share of random orders of the verdicts in which *any* parameter correlates
as much: so it allows for the number of parameters, but not for that of statements. Correlation sees what rises or falls
along a range, not what is best in the middle of it, and not two parameters that act only together.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import binomtest, rankdata

from gaitflow.dataset.sweep import SAMPLE
from gaitflow.report.claims import outcomes

SCORES = {"does not": 0.0, "holds in part": 1.0, "holds": 2.0}
ORDERS = 10_000
SURE = 0.01  # p below which a parameter is said to decide; of 38 statements one in three sweeps would be by chance
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Influence:
    """Rank correlation of a verdict with a parameter, and the p of so large a one with any parameter by chance."""

    correlation: float
    p: float


@dataclass(frozen=True)
class Share:
    """For how many of the robots for which it can be asked a statement holds, or holds in part.

    low, high: exact binomial interval of the share that holds, 95 %. influences: by parameter; empty where all robots
    have one verdict.
    """

    robots: int
    holds: int
    in_part: int
    low: float
    high: float
    influences: Mapping[str, Influence]

    @property
    def decided_by(self) -> tuple[str, ...]:
        """The parameters with a p below SURE, the strongest first."""
        sure = [name for name, found in self.influences.items() if found.p < SURE]
        return tuple(sorted(sure, key=lambda name: -abs(self.influences[name].correlation)))


def sweep_verdicts(labels: Mapping[str, Mapping[int, pd.DataFrame]], exact: bool) -> pd.DataFrame:
    """Verdicts, a row a robot by its number, a column a statement by its id; labels by figure and robot.

    Only robots that every figure has are asked. Raises ValueError when there are none.
    """
    robots = sorted(set.intersection(*(set(frames) for frames in labels.values()))) if labels else []
    if not robots:
        raise ValueError("no robot has labels for every figure; run the sweep of each scenario first")
    rows = [outcomes({figure: frames[robot] for figure, frames in labels.items()}, exact) for robot in robots]
    table = [{name: verdict for name, (verdict, _) in row.items()} for row in rows]
    return pd.DataFrame(table, index=pd.Index(robots, name=SAMPLE))


def sweep_shares(verdicts: pd.DataFrame, parameters: pd.DataFrame) -> dict[str, Share]:
    """The share of each statement; `parameters` has what was drawn, a row a robot by its number."""
    return {str(name): _share(verdicts[name], parameters) for name in verdicts}


def statements_kept(verdicts: pd.DataFrame) -> pd.DataFrame:
    """Columns `holds` and `in_part`, the number of statements a robot, those robots first that keep most."""
    counts = {"holds": (verdicts == "holds").sum(axis=1), "in_part": (verdicts == "holds in part").sum(axis=1)}
    kept = pd.DataFrame(counts)
    return kept.sort_values(["holds", "in_part"], ascending=False, kind="stable")


def _share(verdicts: pd.Series, parameters: pd.DataFrame) -> Share:
    asked = verdicts[verdicts != "not measured"]
    holds, in_part = int((asked == "holds").sum()), int((asked == "holds in part").sum())
    low, high = 0.0, 1.0
    if len(asked):
        interval = binomtest(holds, len(asked)).proportion_ci(CONFIDENCE, method="exact")
        low, high = float(interval.low), float(interval.high)
    scores = np.array([SCORES[verdict] for verdict in asked])
    return Share(len(asked), holds, in_part, low, high, _influences(scores, parameters.loc[asked.index]))


def _influences(scores: NDArray[np.float64], parameters: pd.DataFrame) -> dict[str, Influence]:
    if len(scores) < 3 or np.ptp(scores) == 0.0:
        return {}
    ranks = np.column_stack([_standard(np.asarray(parameters[name], dtype=float)) for name in parameters])
    own = _standard(scores)
    found = own @ ranks
    orders = np.random.default_rng(0).permuted(np.tile(own, (ORDERS, 1)), axis=1)
    largest = np.abs(orders @ ranks).max(axis=1)
    p = [(1 + int((largest >= abs(value) - 1e-12).sum())) / (1 + ORDERS) for value in found]
    return {str(name): Influence(float(r), share) for name, r, share in zip(parameters, found, p, strict=True)}


def _standard(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Ranks about their mean, of length 1; 0 where all values are equal."""
    ranks = rankdata(values) - (len(values) + 1) / 2
    length = float(np.linalg.norm(ranks))
    return np.asarray(ranks / length if length else ranks)
