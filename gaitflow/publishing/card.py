"""The model card, README.md of an artifact: written from the manifest and nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gaitflow.core.gaits import Pattern, diagram
from gaitflow.runtime.manifest import TIME_FORMAT, Manifest

_QUALITY = ("accuracy", "macro_f1", "top1_beyond_ties", "regret_mean", "regret_p95", "infeasible_rate")


def card(manifest: Manifest) -> str:
    """Markdown: what the map is, for which robot and tasks, how good, its limits, how to load it, its licence."""
    sections = (_what, _tasks, _gaits, _quality, _starts, _limits, _use)
    return "\n".join(text for section in sections if (text := section(manifest)))


def _what(manifest: Manifest) -> str:
    scenario = manifest.scenario
    robot, terrain, knots = scenario["robot"], scenario["terrain"], scenario["transcription"]
    weights = ", ".join(f"{name} {weight:g}" for name, weight in scenario["objective"].items() if weight)
    description, legs = scenario.get("description") or "A gait map.", ", ".join(manifest.layout.legs)
    return f"""# {manifest.name} {manifest.version}

{description}

For a task of forward speed and cycle duration it answers which gait costs least, and where an optimiser of that gait
starts.

| | |
| --- | --- |
| robot | {robot["name"]}, {robot["dimension"]}D rigid body of {robot["mass"]:g} kg, legs {legs} |
| terrain | slope {terrain["slope_deg"]:g} degrees, friction coefficient {terrain["friction"]:g} |
| objective | weights: {weights} |
| transcription | {knots["phases"]} phases of {knots["knots_per_phase"]} knots, {knots["integrator"]} |
| created | {manifest.created.strftime(TIME_FORMAT)} |
| scenario | SHA-256 {manifest.scenario_digest} |
| dataset | {_inline(manifest.dataset)} |
"""


def _tasks(manifest: Manifest) -> str:
    domain = manifest.domain
    feasible, total = sum(map(sum, domain.feasible)), len(domain.speeds) * len(domain.cycle_durations)
    return f"""## Tasks

Speed {_range(domain.speeds)} m/s, cycle duration {_range(domain.cycle_durations)} s. Of the {total} tasks of the grid
{feasible} have a feasible gait.
"""


def _gaits(manifest: Manifest) -> str:
    rows = [
        f"| {gait.name} | `{diagram(Pattern.from_text(gait.pattern), manifest.layout.legs)}` |"
        for gait in manifest.gaits
    ]
    return "\n".join([
        "## Gaits", "", "A row of digits a leg, a digit a phase, 1 is stance.", "",
        "| gait | pattern |", "| --- | --- |", *rows, "",
    ])  # fmt: skip


def _quality(manifest: Manifest) -> str:
    """A row a method and a kind of tasks when the metrics have them; else the plain numbers."""
    head = f"## Quality\n\nThe classifier is `{manifest.classifier_kind}`."
    judged = [
        (f"{row['method']}, {kind.replace('_', ' ')}", row[kind])
        for row in manifest.metrics.get("competitors", ())
        for kind in ("cross_validation", "held_out")
        if isinstance(row.get(kind), Mapping)
    ]
    if judged:
        published = manifest.metrics.get("published")
        if isinstance(published, Mapping) and published.get("nodes"):
            name = f"{manifest.classifier_kind} as published, fitted to {published['nodes']} nodes, too: held out"
            judged.append((name, published["held_out"]))
        table = [f"| method | {' | '.join(name.replace('_', ' ') for name in _QUALITY)} |", "| --- " * 7 + "|"]
        table += [f"| {name} | {' | '.join(_number(values.get(key)) for key in _QUALITY)} |" for name, values in judged]
        note = (
            "Regret is the relative cost of the pick over the best gait; infeasible rate counts picks without a motion."
        )
        return "\n".join([head, note, "", *table, ""])
    numbers = [f"| {name} | {_number(value)} |" for name, value in manifest.metrics.items() if _is_number(value)]
    return "\n".join([head, "", "| metric | value |", "| --- | --- |", *numbers, ""])


def _starts(manifest: Manifest) -> str:
    """Where plans start, when the metrics tell of an atlas."""
    atlas = manifest.metrics.get("atlas")
    if not isinstance(atlas, Mapping) or not atlas.get("nodes"):
        return ""
    rows = [
        f"| {row['predictor']} | {row['modes']} | {row['iterations_mean']:.2f} | {row['converged']} of {row['tasks']} |"
        for row in atlas["predictors"]
    ]
    return "\n".join([
        "## Starts", "",
        f"The atlas holds {sum(atlas['nodes'].values())} solved tasks of {len(atlas['nodes'])} patterns, along "
        f"{atlas['modes']} modes. Newton iterations from the prediction at tasks that are none of them:", "",
        "| predictor | modes | iterations, mean | converged |", "| --- | --- | --- | --- |", *rows, "",
    ])  # fmt: skip


def _limits(manifest: Manifest) -> str:
    integrator = {"euler": "forward Euler", "rk4": "a Runge-Kutta step"}.get(
        manifest.scenario["transcription"]["integrator"], "one step"
    )
    return f"""## Limits

- It holds for this robot, terrain and objective, and for periodic motion at a constant speed. Outside the tasks above
  it says that it does not know.
- Gaits are locally optimal: other minima may cost less. Neighbouring gaits may cost the same within a per mille.
- The model is a rigid body with massless legs whose feet stay in boxes; between knots the motion is only as exact as
  {integrator} with equal steps.
- A warm start is a prediction: a start, not a motion to execute. Plans are checked at their knots.
- `problem.casadi` is read by CasADi's native code: load an artifact only from a source you trust.
"""


def _use(manifest: Manifest) -> str:
    feasible = [
        (v, t)
        for v, row in zip(manifest.domain.speeds, manifest.domain.feasible, strict=True)
        for t, inside in zip(manifest.domain.cycle_durations, row, strict=True)
        if inside
    ]
    v, t = feasible[len(feasible) // 2] if feasible else (manifest.domain.speeds[0], manifest.domain.cycle_durations[0])
    return f"""## Use

```python
from gaitflow.runtime import GaitMap

gait_map = GaitMap.load("models/{manifest.name}/{manifest.version}")
choice = gait_map.select(speed={v:g}, cycle_duration={t:g})
plan = gait_map.plan(speed={v:g}, cycle_duration={t:g})  # needs gaitflow[solve]
```

`gaitflow verify` checks the files, of which `manifest.json` lists the digests.

## Licence

BSD-3-Clause, as gaitflow itself.
"""


def _range(axis: tuple[float, ...]) -> str:
    return f"{axis[0]:g}" if len(axis) == 1 else f"{axis[0]:g} to {axis[-1]:g} ({len(axis)} values)"


def _number(value: Any) -> str:
    return f"{value:.4g}" if _is_number(value) else "-"


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _inline(data: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} {value}" for name, value in data.items())
