"""The model card, README.md of a map: written from the manifest and nothing else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from gaitflow.core.gaits import Pattern, diagram
from gaitflow.core.task import AXES
from gaitflow.publishing.judge_map import BEYOND
from gaitflow.runtime.manifest import TIME_FORMAT, Manifest

_QUALITY = ("accuracy", "macro_f1", "top1_beyond_ties", "regret_mean", "regret_p95", "infeasible_rate")
_MOTIONS = {
    "euler": "forward Euler",
    "rk4": "a Runge-Kutta step",
    "midpoint": "the implicit midpoint rule",
    "hermite_simpson": "a cubic and Simpson's rule",
    "momentum": "momentum that is exact and a cubic",
}


def card(manifest: Manifest) -> str:
    """Markdown: what the map is, for which robot and tasks, how good, its limits, how to load it, its licence."""
    sections = (_what, _beyond_limits, _tasks, _gaits, _certificate, _quality, _starts, _limits, _use)
    return "\n".join(text for section in sections if (text := section(manifest)))


def _what(manifest: Manifest) -> str:
    scenario = manifest.scenario
    robot, knots, legs = scenario["robot"], scenario["transcription"], ", ".join(_legs(manifest))
    weights = ", ".join(f"{name} {weight:g}" for name, weight in scenario["objective"].items() if weight)
    motion = f"{knots['integrator']}, {knots['forces']} forces"
    description, axes = scenario.get("description") or "A gait map.", " and ".join(_named(manifest.domain.axes))
    return f"""# {manifest.name} {manifest.version}

{description}

For a task, {axes}, it answers which gait costs least, and where an optimiser of that gait starts.

| | |
| --- | --- |
| robot | {robot["name"]}, {robot["dimension"]}D rigid body of {robot["mass"]:g} kg, legs {legs} |
| objective | weights: {weights} |
| transcription | {knots["phases"]} phases of {knots["knots_per_phase"]} knots, {motion} |
| created | {manifest.created.strftime(TIME_FORMAT)} |
| scenario | SHA-256 {manifest.scenario_digest} |
| dataset | {manifest.dataset["name"]} {manifest.dataset["version"]} |
"""


def _beyond_limits(manifest: Manifest) -> str:
    """What of the map is worse than its scenario allows; nothing for a map within its limits."""
    faults = manifest.metrics.get(BEYOND)
    if not isinstance(faults, Sequence) or isinstance(faults, str) or not faults:
        return ""
    listed = "\n".join(f"- {fault}" for fault in faults)
    return f"""## Beyond its limits

**This map was published although it is worse than its scenario allows:**

{listed}
"""


def _tasks(manifest: Manifest) -> str:
    domain = manifest.domain
    rows = [f"| {_name(axis)} | {_range(values)} {_unit(axis)} |" for axis, values in domain.axes.items()]
    rows += [f"| {_name(axis)} | {value:g} {_unit(axis)} |" for axis, value in manifest.space.fixed]
    on_grid = "sampling" not in manifest.scenario["tasks"]
    chosen = "" if on_grid else "The grid tells the domain; the map was made from tasks chosen anywhere between. "
    return "\n".join([
        "## Tasks", "", "| axis | values |", "| --- | --- |", *rows, "",
        f"Of the {domain.feasible.size} tasks of the grid {int(domain.feasible.sum())} have a feasible gait. "
        f"{chosen}All other axes of a task have their defaults.", "",
    ])  # fmt: skip


def _gaits(manifest: Manifest) -> str:
    legs = _legs(manifest)
    rows = [f"| {gait.name} | `{diagram(Pattern.from_text(gait.pattern), legs)}` |" for gait in manifest.gaits]
    return "\n".join([
        "## Gaits", "", "A row of digits a leg, a digit a phase, 1 is stance.", "",
        "| gait | pattern |", "| --- | --- |", *rows, "",
    ])  # fmt: skip


def _quality(manifest: Manifest) -> str:
    """A row a method and a kind of tasks when the metrics have them; else the plain numbers."""
    head = (
        "## Quality\n\nWhat the map picks is the gait that its atlas predicts to cost least, over more than three axes "
        f"least over its probability. The classifier, a `{manifest.classifier_kind}`, tells probabilities, and picks "
        "where the atlas knows nothing."
    )
    judged = [
        (f"{row['method']}, {kind.replace('_', ' ')}", row[kind])
        for row in manifest.metrics.get("competitors", ())
        for kind in ("cross_validation", "held_out")
        if isinstance(row.get(kind), Mapping)
    ]
    if judged:
        published = manifest.metrics.get("published")
        if isinstance(published, Mapping) and published.get("atlas_tasks"):
            fitted = f"fitted to {published['atlas_tasks']} tasks of the atlas, too"
            judged.append((f"{manifest.classifier_kind} as published, {fitted}: held out", published["held_out"]))
            judged.append(("**what the map picks: held out**", published["map_held_out"]))
        table = [f"| method | {' | '.join(name.replace('_', ' ') for name in _QUALITY)} |", "| --- " * 7 + "|"]
        table += [f"| {name} | {' | '.join(_number(values.get(key)) for key in _QUALITY)} |" for name, values in judged]
        note = (
            "Regret is the relative cost of the pick over the best gait; infeasible rate counts picks without a motion."
        )
        return "\n".join([head, note, "", *table, ""])
    numbers = [f"| {name} | {_number(value)} |" for name, value in manifest.metrics.items() if _is_number(value)]
    return "\n".join([head, "", "| metric | value |", "| --- | --- |", *numbers, ""])


def _certificate(manifest: Manifest) -> str:
    """What holds for the map's plans, or for its picks in an older map, when the metrics have a certificate."""
    found = manifest.metrics.get("certificate")
    if not isinstance(found, Mapping):
        return ""
    selected = found.get("selected_bound")
    what, none = ("pick", "one without a motion") if selected is None else ("plan", "none")
    of_selections = (
        ""
        if selected is None
        else f"""
`select` names a gait before anything is solved: at {found["selected_dearer"]} of the searched tasks one that is more
than {found["tolerance"]:.0%} dearer. With the same confidence, for this bound alone, these are at most
**{selected:.2%}** of the domain's tasks. A plan tries other gaits that may be cheaper, too.
"""
    )
    return f"""## Certificate

With {found["confidence"]:.0%} confidence at most **{found["dearer_bound"]:.2%}** of the domain's tasks get a {what}
that is more than {found["tolerance"]:.0%} dearer than the best gait that the search finds, and at most
**{found["infeasible_bound"]:.2%}** {none}. {found["searched"]} random tasks that had no part in making the map were
searched: {found["dearer"]} {what}s were dearer. {found["planned"]} were planned: at {found["infeasible"]} no motion was
found. The bounds are exact (binomial). They hold although this was asked {found["asking"]} time(s) while the map was
made: each asking had a part of the 5 % chance of error. `gaitflow certify` asks again, at tasks of your own seed.
{of_selections}"""


def _starts(manifest: Manifest) -> str:
    """Where plans start, when the metrics tell of an atlas."""
    atlas = manifest.metrics.get("atlas")
    if not isinstance(atlas, Mapping) or not atlas.get("nodes"):
        return ""
    judged = atlas["predictions"]
    iterations, median, most = (
        _number(judged[key]) for key in ("iterations_mean", "cost_error_median", "cost_error_p95")
    )
    return f"""## Starts

The atlas holds {sum(atlas["nodes"].values())} solved tasks of {len(atlas["nodes"])} patterns with their tangents. From
its predictions at {judged["tasks"]} random tasks Newton's method reached the optimum {judged["converged"]} times, in
{iterations} iterations on average; predicted costs were off by {median} (median) and {most} (95th percentile), as a
share.
"""


def _limits(manifest: Manifest) -> str:
    motion = _MOTIONS.get(manifest.scenario["transcription"]["integrator"], "one step")
    return f"""## Limits

- It holds for this robot, ground and objective, and for periodic motion. Outside the tasks above it says that it does
  not know.
- Gaits are locally optimal: other minima may cost less. Neighbouring gaits may cost the same within a per mille.
- The model is a rigid body with massless legs whose feet stay in boxes; between knots the motion is only as exact as
  {motion}.
- A warm start is a prediction: a start, not a motion to execute. Plans are checked at their knots.
"""


def _use(manifest: Manifest) -> str:
    domain = manifest.domain
    task = domain.middle if domain.feasible.any() else {axis: values[0] for axis, values in domain.axes.items()}
    asked = ", ".join(f"{axis}={value:g}" for axis, value in task.items())
    return f"""## Use

```python
from gaitflow.runtime import GaitMap

gait_map = GaitMap.load("models/{manifest.name}/{manifest.version}")
choice = gait_map.select({asked})
plan = gait_map.plan({asked})  # needs gaitflow[solve]
```

`gaitflow verify` checks the files, of which `manifest.json` lists the digests. They are data: the problem of a plan is
made anew from the manifest's scenario, and compared with `problem_check.safetensors`.

## Licence

BSD-3-Clause, as gaitflow itself.
"""


def _legs(manifest: Manifest) -> list[str]:
    return [leg["name"] for leg in manifest.scenario["robot"]["legs"]]


def _named(axes: Mapping[str, Any]) -> list[str]:
    return [_name(axis) for axis in axes]


def _name(axis: str) -> str:
    return axis.replace("_", " ")


def _unit(axis: str) -> str:
    unit = AXES[axis].unit
    return "" if unit == "1" else unit


def _range(axis: tuple[float, ...]) -> str:
    return f"{axis[0]:g}" if len(axis) == 1 else f"{axis[0]:g} to {axis[-1]:g} ({len(axis)} values)"


def _number(value: Any) -> str:
    return f"{value:.4g}" if _is_number(value) else "-"


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
