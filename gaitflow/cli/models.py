"""`gaitflow models`: which maps there are, and where two of them disagree."""

from __future__ import annotations

import statistics
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gaitflow.cli.errors import bad_input, print_json, refused_artifact
from gaitflow.cli.options import PUBLISHED, json_option
from gaitflow.core.task import AXES
from gaitflow.pipeline.workspace import Workspace

if TYPE_CHECKING:
    from gaitflow.report.map_difference import Disagreement, MapDifference
    from gaitflow.runtime.manifest import Manifest

SHOWN = 10  # disagreements, the dearest


@click.group()
def models() -> None:
    """List published maps, or compare two of them.

    \b
    Example: gaitflow models list
    """


@models.command("list")
@json_option
@click.pass_obj
def list_models(workspace: Workspace, as_json: bool) -> None:
    """List every published version of every map.

    For each: robot, axes, gaits, dataset, and how good its picks are on held-out tasks.

    \b
    Example: gaitflow models list
    """
    from gaitflow.core.errors import ArtifactError
    from gaitflow.publishing import published
    from gaitflow.runtime.manifest_file import read_manifest

    rows: list[dict[str, Any]] = []
    for folder in sorted(each for each in workspace.models.glob("*") if each.is_dir()):
        for version in published(folder):
            try:
                rows.append(_row(read_manifest(version.path), version.path))
            except ArtifactError as error:
                rows.append({"folder": str(version.path), "fault": str(error)})
    if as_json:
        return print_json(rows)
    for row in rows:
        if "fault" in row:
            click.echo(f"{row['folder']}: cannot be read: {row['fault']}")
            continue
        axes, gaits = ", ".join(row["axes"]), len(row["gaits"])
        regret = "" if row["regret_mean"] is None else f", mean regret {row['regret_mean']:.2%}"
        click.echo(f"{row['name']} {row['version']}: {row['robot']}, {axes}, {gaits} gaits{regret}, {row['created']}")
    if not rows:
        click.echo(f"no map is published in {workspace.models}")


def _row(manifest: Manifest, folder: Path) -> dict[str, Any]:
    judged = (manifest.metrics.get("published") or {}).get("map_held_out") or {}
    return {
        "name": manifest.name,
        "version": str(manifest.version),
        "folder": str(folder),
        "created": f"{manifest.created:%Y-%m-%d}",
        "robot": manifest.scenario["robot"]["name"],
        "axes": {axis: [values[0], values[-1]] for axis, values in manifest.domain.axes.items()},
        "gaits": [gait.name for gait in manifest.gaits],
        "dataset": dict(manifest.dataset),
        "regret_mean": judged.get("regret_mean"),
        "infeasible_rate": judged.get("infeasible_rate"),
    }


@models.command()
@click.argument("first", type=PUBLISHED)
@click.argument("second", type=PUBLISHED)
@json_option
def diff(first: Path, second: Path, as_json: bool) -> None:
    """Say where two maps choose different gaits, and what that costs.

    FIRST and SECOND are folders of versions, or their parents. Both maps are asked at the grid tasks of both. Each
    map's own atlas predicts how much more the other map's gait costs.

    \b
    Example: gaitflow models diff models/anymal-flat-vibration/1.1.0 models/anymal-flat-vibration/1.2.0
    """
    from gaitflow.report.map_difference import map_difference
    from gaitflow.runtime.artifact import load_artifact
    from gaitflow.runtime.versions import resolve

    with bad_input(), refused_artifact():
        artifacts = [load_artifact(resolve(path)) for path in (first, second)]
        difference = map_difference(*artifacts)
    if as_json:
        return print_json(asdict(difference))
    names = [f"{one.manifest.name} {one.manifest.version}" for one in artifacts]
    if names[0] == names[1]:
        names = [str(first), str(second)]
    _say(difference, names)


def _say(difference: MapDifference, names: list[str]) -> None:
    different = difference.disagreements
    share = f" ({len(different) / difference.tasks:.1%})" if difference.tasks else ""
    click.echo(f"tasks:     {difference.tasks} that both answer, at {len(different)}{share} by different gaits")
    for name, alone in zip(names, (difference.only_first, difference.only_second), strict=True):
        if alone:
            click.echo(f"alone:     {name} answers at {alone} more")
    for name, gaits in zip(names, (difference.gaits_first, difference.gaits_second), strict=True):
        if gaits:
            click.echo(f"gaits:     only {name} has {', '.join(gaits)}")
    if not different:
        return
    columns = [one.first_excess for one in different], [one.second_excess for one in different]
    for judge, other, excess in zip(names, reversed(names), columns, strict=True):
        click.echo(f"cost:      by {judge}, the gaits of {other} cost there {_spread(excess)}")
    ordered = sorted(different, key=_dearest, reverse=True)
    for one in ordered[:SHOWN]:
        task = ", ".join(f"{axis} {AXES[axis].written(value)}" for axis, value in one.task.items())
        dearer = " and ".join("unknown" if x is None else f"{x:+.2%}" for x in (one.first_excess, one.second_excess))
        click.echo(f"  {task}: {one.first} / {one.second}, the other's costs {dearer}")
    if len(ordered) > SHOWN:
        click.echo(f"  and {len(ordered) - SHOWN} more that differ by less; --json lists them all")


def _spread(excess: Iterable[float | None]) -> str:
    found = list(excess)
    known = [each for each in found if each is not None]
    unknown = f"; unknown at {len(found) - len(known)}" if len(known) < len(found) else ""
    if not known:
        return "an unknown amount more"
    return f"{statistics.median(known):+.2%} (median), {max(known):+.2%} (most){unknown}"


def _dearest(one: Disagreement) -> float:
    return max((x for x in (one.first_excess, one.second_excess) if x is not None), default=float("inf"))
