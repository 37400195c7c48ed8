"""The document of a sweep: for which share of robots each statement of the paper holds, by whom, decided by what."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from gaitflow.config.scenario import Scenario
from gaitflow.config.sweep import Factor, Sweep
from gaitflow.report.claims import CHECKS
from gaitflow.report.sweep_shares import SURE, Share, statements_kept, sweep_shares

WIDTH = 120  # of a page
RULES = ("forward Euler", "exact motion")
BEST = 3  # robots that keep most statements, in the page's table
STATEMENTS = {check.id: check.statement for check in CHECKS}


@dataclass(frozen=True)
class RuleOfMotion:
    """What a sweep came to by forward Euler, or by exact motion.

    scenarios: by figure. verdicts: a row a robot, a column a statement. ours: the verdict of the scenarios' own robot
    on the same tasks, by statement; empty where it was not published.
    """

    name: str
    scenarios: Mapping[str, Scenario]
    verdicts: pd.DataFrame
    ours: Mapping[str, str]


@dataclass(frozen=True)
class SweepResult:
    """A sweep, what was drawn (a row a robot by its number), and what it came to by each rule of motion."""

    sweep: Sweep
    parameters: pd.DataFrame
    rules: Sequence[RuleOfMotion]

    @property
    def shares(self) -> dict[str, dict[str, Share]]:
        """The share of each statement, by rule of motion."""
        return {rule.name: sweep_shares(rule.verdicts, self.parameters) for rule in self.rules}


def sweep_data(result: SweepResult) -> dict[str, Any]:
    """The document as plain JSON data: sweep, shares by rule and statement, robots with their verdicts."""
    shares = result.shares
    return {
        "sweep": result.sweep.as_data(),
        "rules": [
            {
                "name": rule.name,
                "scenarios": {figure: scenario.name for figure, scenario in rule.scenarios.items()},
                "statements": [_statement(name, one, rule.ours) for name, one in shares[rule.name].items()],
                "robots": [
                    {"sample": int(str(number)), "verdicts": dict(row)} for number, row in rule.verdicts.iterrows()
                ],
            }
            for rule in result.rules
        ],
        "robots": [{"sample": int(str(number)), "values": dict(row)} for number, row in result.parameters.iterrows()],
    }


def sweep_page(result: SweepResult, picture: str) -> str:
    """The document as Markdown; `picture` is the file of `draw_sweep`, beside the page."""
    shares = result.shares
    lines = [f"# {len(result.parameters)} robots and the paper's statements", ""]
    made = (
        f"Made by `gaitflow report --sweep {result.sweep.name}` from the tables that `gaitflow sweep` wrote; how to "
        "read it: [sweep.md](../sweep.md). The share of robots for which a statement holds has its exact binomial "
        "interval (95 %). *Decided by* are the parameters whose rank correlation with the verdict (in brackets, + "
        f"where it holds for larger values) has a p < {SURE:g}."
    )
    lines += [
        textwrap.fill(made, WIDTH),
        "",
        *_ranges(result.sweep),
        "",
        f"![Shares of robots, and rank correlations with parameters]({picture})",
        "",
    ]
    for rule in result.rules:
        names = ", ".join(f"`{scenario.name}`" for scenario in rule.scenarios.values())
        lines += [f"## By {rule.name}", "", f"Scenarios: {names}.", ""]
        lines += [*_table(shares[rule.name], rule.ours), ""]
    lines += ["## The robots that keep most statements", "", *_best(result)]
    return "\n".join(lines) + "\n"


def share_texts(data: Mapping[str, Any]) -> dict[str, dict[str, str]]:
    """Of `sweep_data`: by rule and statement, how many robots keep it, such as "31 of 48 (49 to 78 %)"."""
    return {
        rule["name"]: {
            one["id"]: _told(one["robots"], one["holds"], one["low"], one["high"]) for one in rule["statements"]
        }
        for rule in data["rules"]
    }


def _statement(name: str, share: Share, ours: Mapping[str, str]) -> dict[str, Any]:
    return {
        "id": name,
        "statement": STATEMENTS[name],
        "robots": share.robots,
        "holds": share.holds,
        "in_part": share.in_part,
        "low": share.low,
        "high": share.high,
        "ours": ours.get(name),
        "decided_by": list(share.decided_by),
        "influences": {key: {"correlation": one.correlation, "p": one.p} for key, one in share.influences.items()},
    }


def _ranges(sweep: Sweep) -> list[str]:
    lines = ["| parameter | range |", "| --- | --- |"]
    for name, span in sweep.ranges.items():
        low, high = span.factor if isinstance(span, Factor) else span
        lines.append(f"| `{name}` | {low:g} to {high:g}{' times ours' if isinstance(span, Factor) else ''} |")
    return lines


def _table(shares: Mapping[str, Share], ours: Mapping[str, str]) -> list[str]:
    titles = ["id", "the paper's statement", "holds for", "in part for", "our robot, same tasks", "decided by"]
    lines = [f"| {' | '.join(titles)} |", f"|{' --- |' * len(titles)}"]
    for name, one in shares.items():
        decided = ", ".join(f"{key} ({one.influences[key].correlation:+.2f})" for key in one.decided_by)
        told = _told(one.robots, one.holds, one.low, one.high)
        cells = (name, STATEMENTS[name], told, str(one.in_part), ours.get(name, ""), decided)
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def _told(robots: int, holds: int, low: float, high: float) -> str:
    return f"{holds} of {robots} ({low:.0%} to {high:.0%})".replace("% to", " to").replace("%)", " %)")


def _best(result: SweepResult) -> list[str]:
    kept = {rule.name: statements_kept(rule.verdicts) for rule in result.rules}
    if len(kept) > 1:
        both = pd.concat([rule.verdicts.add_prefix(f"{rule.name} ") for rule in result.rules], axis=1, join="inner")
        kept["both"] = statements_kept(both)
    asked = {rule.name: rule.verdicts.shape[1] for rule in result.rules}
    asked["both"] = sum(asked.values())
    names = list(result.sweep.ranges)
    titles = ["by", "robot", "holds", "in part", *names]
    lines = [f"| {' | '.join(titles)} |", f"|{' --- |' * len(titles)}"]
    for rule, table in kept.items():
        for number, row in table.head(BEST).iterrows():
            values = [f"{value:.3g}" for value in result.parameters.loc[int(str(number)), names]]
            cells = [rule, str(number), f"{row['holds']} of {asked[rule]}", str(row["in_part"]), *values]
            lines.append(f"| {' | '.join(cells)} |")
    return lines
