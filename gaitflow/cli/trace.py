"""`gaitflow trace`: from a map's answer back to the solves that decided it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gaitflow.cli.errors import bad_input, print_json, refused_artifact
from gaitflow.cli.options import PUBLISHED, json_option, task_options
from gaitflow.core.task import AXES
from gaitflow.pipeline.workspace import Workspace

if TYPE_CHECKING:
    from gaitflow.report.trace import Answer, Decision
    from gaitflow.runtime.manifest import Manifest


@click.command()
@click.argument("model", metavar="MAP", type=PUBLISHED)
@task_options
@json_option
@click.pass_obj
def trace(workspace: Workspace, model: Path, axes: dict[str, Any], as_json: bool) -> None:
    """Say which solves, commit and machine an answer of MAP comes from.

    MAP is the folder of a version, or its parent. The command prints the gaits by predicted cost, each with the nearest
    node of the atlas; then the solves that decided the label of the nearest task in the map's dataset; and commit and
    machine of both. Without a task it prints only what made the map and its dataset.

    \b
    Example: gaitflow trace models/half-cheetah-exact-slopes --speed 0.9 --cycle 0.6 --slope 8
    """
    from gaitflow.dataset.read import load_solutions
    from gaitflow.publishing.find import dataset_of_map, learnt_from
    from gaitflow.report.trace import answer_of, decision_of
    from gaitflow.runtime import OutOfDomain
    from gaitflow.runtime.artifact import load_artifact
    from gaitflow.runtime.versions import resolve

    with bad_input(), refused_artifact():
        folder = resolve(model)
        artifact = load_artifact(folder)
        dataset = dataset_of_map(folder, workspace.datasets)
        solutions = None if dataset is None else load_solutions(dataset)
        try:
            answer = answer_of(artifact, axes) if axes else None
        except OutOfDomain as error:
            raise ValueError(str(error)) from None
        decision = None if answer is None or solutions is None else decision_of(solutions, answer.task)
    manifest = artifact.manifest
    made_by = decision.made_by if decision else tuple(solutions.record["made_by"]) if solutions else ()
    if as_json:
        return print_json(_data(folder, manifest, dataset, answer, decision, made_by))
    told = f"{manifest.name} {manifest.version}, published {manifest.created:%Y-%m-%d}"
    click.echo(f"map:       {told} by {_maker(manifest.code)}")
    learnt = learnt_from(manifest)
    if solutions is None:
        click.echo(f"dataset:   {learnt}, which is not here; its solves are not known")
    else:
        click.echo(f"dataset:   {learnt}, {solutions.record['units']} units of work, in {dataset}")
    if answer is not None:
        _say_answer(answer)
    if decision is not None:
        _say_decision(decision)
    for maker in made_by:
        click.echo(f"solved by: {_maker(maker)}")


def _say_answer(answer: Answer) -> None:
    click.echo(f"task:      {_text(answer.task)}")
    if answer.gait is None:
        click.echo("answer:    none: the task lies outside the map's domain")
        return
    by = "by predicted cost" if answer.known else "by the classifier, as the atlas knows no gait there"
    click.echo(f"answer:    {answer.gait}, {by}; the classifier gives it {answer.probability:.2f}")
    for one in answer.known:
        node = f"nearest node {_text(one.node)}, cost {one.node_cost:.6g}"
        click.echo(f"  {one.cost:<12.6g} {one.gait} ({one.pattern}); {node}")


def _say_decision(decision: Decision) -> None:
    counts = ", ".join(f"{count} {status}" for status, count in decision.statuses.items())
    click.echo(f"nearest:   {decision.task.text(decision.axes)}: {counts}")
    for row in decision.solves:
        refined, knots = row["refined_cost"], row["refined_knots"]
        finer = "" if math.isnan(refined) else f", {refined:.6g} on {knots} knots a phase"
        how = f"{row['strategy']}, start {row['start']}, seed {row['seed']}, {row['iterations']} iterations"
        click.echo(f"  {row['cost']:<12.6g} {row['gait']} ({row['pattern']}){finer}; {how}, {row['cpu_s']:.2f} CPU s")
    click.echo(f"margin:    {decision.margin:.3%}")
    if decision.unit is not None:
        click.echo(f"unit:      {decision.unit}")


def _text(task: Mapping[str, float]) -> str:
    return ", ".join(f"{axis} {AXES[axis].written(value)}" for axis, value in task.items())


def _maker(made_by: Mapping[str, Any]) -> str:
    """One line of who made something: code, commit, machine."""
    code = made_by.get("code", {})
    changed = " with uncommitted changes" if code.get("dirty") else ""
    packages = ", ".join(f"{name} {version}" for name, version in made_by.get("packages", {}).items())
    parts = [
        f"gaitflow {code.get('version', 'unknown')} at commit {code.get('commit', 'unknown')}{changed}",
        *(str(made_by[key]) for key in ("cpu", "system") if key in made_by),
        *([f"Python {made_by['python']}"] if "python" in made_by else []),
        *([packages] if packages else []),
    ]
    return "; ".join(parts)


def _data(
    folder: Path,
    manifest: Manifest,
    dataset: Path | None,
    answer: Answer | None,
    decision: Decision | None,
    made_by: tuple[Mapping[str, Any], ...],
) -> dict[str, Any]:
    data: dict[str, Any] = {
        "map": {"name": manifest.name, "version": str(manifest.version), "folder": str(folder)},
        "map_made_by": dict(manifest.code),
        "dataset": dict(manifest.dataset) | {"folder": None if dataset is None else str(dataset)},
        "answer": None,
        "decision": None,
        "solved_by": [dict(maker) for maker in made_by],
    }
    if answer is not None:
        known = [dict(vars(one)) for one in answer.known]
        data["answer"] = dict(vars(answer)) | {"known": known}
    if decision is not None:
        data["decision"] = {
            "task": dict(zip(decision.axes, decision.task.on(decision.axes), strict=True)),
            "margin": _finite(decision.margin),
            "statuses": dict(decision.statuses),
            "solves": [{key: _finite(value) for key, value in row.items()} for row in decision.solves],
            "unit": decision.unit,
        }
    return data


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
