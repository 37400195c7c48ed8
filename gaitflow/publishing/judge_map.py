"""Whether a map is good enough to be published, by the limits of its scenario."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gaitflow.config.limits import Limits
from gaitflow.config.sampling import Sampling

BEYOND = (
    "beyond_limits"  # among a manifest's metrics: what `faults_of_map` found when the map was published all the same
)


def faults_of_map(limits: Limits, metrics: Mapping[str, Any], certificate: Mapping[str, Any] | None) -> list[str]:
    """What of a map lies beyond its limits, a sentence each; nothing where nothing was measured.

    `metrics` is `Training.as_data()`: its picks on held-out tasks count. `certificate` is the document of the bench
    `certificate` for this problem, None where there is none.
    """
    picks = (metrics.get("published") or {}).get("map_held_out") or {}
    gap = None if certificate is None else certificate["summary"]["gap_max_rel"]
    measured = [
        ("regret_mean", "mean cost regret of the picks on held-out tasks", picks.get("regret_mean")),
        ("infeasible_rate", "share of picks on held-out tasks without a known motion", picks.get("infeasible_rate")),
        ("certificate_gap", "share by which a label costs more than what its certificate found", gap),
    ]
    return [
        f"{what} is {value:.3g}, more than limits.{name} = {getattr(limits, name):g}"
        for name, what, value in measured
        if value is not None and value > getattr(limits, name)
    ]


def outdated(certificate: Mapping[str, Any] | None, learning: str) -> str | None:
    """Why a map's certificate is not of the map's plans, in one sentence; None where it is, or where there is none.

    `learning` is the digest of what trains the map's classifier, which its plans ask.
    """
    if certificate is None or certificate.get("learning") == learning:
        return None
    return "the certificate was asked before the classifier's training changed: `gaitflow solve` asks it again"


def faults_of_certificate(goal: Sampling, certificate: Mapping[str, Any] | None) -> list[str]:
    """What of a map's certificate misses the goal of its sampling, a sentence each; a map without one misses it."""
    if certificate is None:
        return [f"no certificate of the map as it is: tasks.sampling.most = {goal.most} left too few searches for one"]
    measured = [
        ("dearer", "share of tasks whose plan may be too dear", certificate["dearer_bound"]),
        ("infeasible", "share of tasks that may have no plan", certificate["infeasible_bound"]),
    ]
    return [
        f"{what}, by the certificate, is {value:.3g}, more than tasks.sampling.{name} = {getattr(goal, name):g}"
        for name, what, value in measured
        if value > getattr(goal, name)
    ]


def disregarded(certificate: Mapping[str, Any], problem: str) -> str | None:
    """Why a certificate does not count for labels of the problem with this digest, in one line; None where it does.

    It is found by the scenario's name, and a scenario may have changed since.
    """
    found = certificate["summary"].get("problem")
    if found == problem:
        return None
    told = "an unnamed problem" if found is None else f"problem {found[:12]}"
    return (
        f"the certificate does not count: it is of {told}, the scenario's is {problem[:12]}; "
        f"`gaitflow bench certificate {certificate['scenario']}` searches again"
    )
