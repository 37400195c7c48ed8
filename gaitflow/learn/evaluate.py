"""How good picks of gaits are: not only whether they match the label, but what a wrong pick costs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from sklearn.metrics import f1_score

from gaitflow.learn.classifier import Floats, Integers
from gaitflow.tables.schema import task_columns

RULE = (
    "Judged on cross-validation folds only: the methods whose infeasible-pick rate is within one task of the least; "
    "of these, the ones whose mean cost regret is within the tie tolerance of the least; of these, the one that "
    "answers fastest (mlp, svm, forest, knn)."
)


@dataclass(frozen=True)
class Quality:
    """Judgement of the first picks at `tasks` tasks that have a label; rates and regret are fractions.

    A pick is infeasible when the costs know no feasible motion of that gait at the task; such picks have no regret
    and are counted apart. Numbers are NaN where there is nothing to average.
    """

    tasks: int
    accuracy: float  # picks that are the label
    macro_f1: float  # mean over the gaits that are label or pick
    top1_beyond_ties: float  # picks that tie with the cheapest gait
    regret_mean: float  # (cost of the pick - least cost) / least cost, over the feasible picks
    regret_p95: float
    infeasible_rate: float  # first pick infeasible
    infeasible_top2: float  # first and second pick infeasible


def judge(probabilities: Floats, classes: Sequence[str], labels: pd.DataFrame, costs: pd.DataFrame) -> Quality:
    """Quality of probabilities [n, C] over `classes` at the n tasks of `labels`, each of them solved.

    `labels` and `costs` are the frames of `gaitflow.dataset.labels`.
    """
    return judge_order(np.argsort(-probabilities, axis=1, kind="stable"), classes, labels, costs)


def judge_order(order: Integers, classes: Sequence[str], labels: pd.DataFrame, costs: pd.DataFrame) -> Quality:
    """Quality of an order [n, C] in which gaits, their places in `classes`, are picked; the rest as in `judge`."""
    n = len(labels)
    if n == 0:
        return Quality(0, *[float("nan")] * 7)
    ranked = order[:, :2]
    picked = np.take_along_axis(_excess_table(labels, costs, classes), ranked, axis=1)
    names = np.asarray(classes, dtype=object)[ranked[:, 0]]
    truth = labels["label"].to_numpy(dtype=object)
    feasible = np.isfinite(picked[:, 0])
    regret = picked[feasible, 0]
    return Quality(
        tasks=n,
        accuracy=float(np.mean(names == truth)),
        macro_f1=float(f1_score(truth, names, average="macro", zero_division=0.0)),
        top1_beyond_ties=float(np.mean([name in ties for name, ties in zip(names, labels["ties"], strict=True)])),
        regret_mean=float(regret.mean()) if len(regret) else float("nan"),
        regret_p95=float(np.quantile(regret, 0.95)) if len(regret) else float("nan"),
        infeasible_rate=float(np.mean(~feasible)),
        infeasible_top2=float(np.mean(~np.isfinite(picked).any(axis=1))),
    )


def choose(qualities: Mapping[str, Quality], tie_tolerance: float) -> str:
    """The method that RULE picks; `qualities` are from cross-validation folds, the fastest method first."""
    rates = {name: quality.infeasible_rate for name, quality in qualities.items()}
    slack = 1.0 / max(next(iter(qualities.values())).tasks, 1)
    safe = [name for name, rate in rates.items() if rate <= min(rates.values()) + slack + 1e-12]
    regrets = {name: np.nan_to_num(qualities[name].regret_mean, nan=np.inf) for name in safe}
    return next(name for name in safe if regrets[name] <= min(regrets.values()) + tie_tolerance)


def _excess_table(labels: pd.DataFrame, costs: pd.DataFrame, classes: Sequence[str]) -> Floats:
    """By how much [n, C] each gait is dearer than the best at each task, as a share; inf without a feasible motion."""
    task = task_columns(labels.columns)
    table = costs.pivot(index=task, columns="gait", values="excess")
    index = pd.MultiIndex.from_frame(labels[task])
    return table.reindex(index=index, columns=pd.Index(classes)).fillna(np.inf).to_numpy(dtype=float)
