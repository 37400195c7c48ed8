"""The stages of a map as commands: run, solve, label, atlas, train, publish, report."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from gaitflow.cli.errors import bad_input, fail, print_json, refused_artifact, warn_of_training
from gaitflow.cli.options import PUBLISHED, json_option, profile_option, scenario_argument, workers_option
from gaitflow.config.file import ConfigError
from gaitflow.core.task import AXES
from gaitflow.pipeline import published, stages
from gaitflow.pipeline.json_file import read_json
from gaitflow.pipeline.snakemake import run_workflow
from gaitflow.pipeline.sweep import shares_of_robots, sweep_report
from gaitflow.pipeline.workspace import Workspace
from gaitflow.runtime.remote import local_folder


@click.command()
@scenario_argument
@workers_option
@profile_option
@click.option("--dry-run", is_flag=True, help="Say which stages would run, and run none.")
@click.pass_obj
def run(workspace: Workspace, scenario: str, workers: int, profile_file: Path | None, dry_run: bool) -> None:
    """Make the map of SCENARIO, from solving to the report.

    The stages are solve, label, atlas, train, publish, report; those that are up to date are left out. With --profile
    the workers that solve are jobs of a cluster; the other stages run here. Stop it with Ctrl-C; the same command goes
    on where it stopped.

    \b
    Example: gaitflow run quickstart
    """
    from gaitflow.config.cluster import load_profile
    from gaitflow.learn.installed import check_installed

    with bad_input():
        resolved = workspace.scenario(scenario)
        check_installed(resolved.learning)
        if profile_file is not None:
            load_profile(profile_file)
        if not run_workflow(workspace, resolved, scenario, workers, dry_run, profile_file):
            fail(f"the workflow of {resolved.name} did not finish; what is done is kept, the same command goes on")
    if dry_run:
        return
    from gaitflow.runtime import GaitMap

    folder = workspace.run(resolved)
    published = read_json(folder.published)
    gait_map = GaitMap.load(published["model"])
    task: dict[str, Any] = gait_map.manifest.domain.middle
    choice = gait_map.select(**task)
    click.echo(f"map:      {published['model']}")
    click.echo(f"dataset:  {published['dataset']}")
    asked = ", ".join(f"{axis} {value:g} {AXES[axis].unit}" for axis, value in task.items())
    click.echo(f"query:    {asked} -> {choice.gait} ({choice.pattern}), probability {choice.probability:.2f}")
    click.echo(f"picture:  {folder.report / 'map.png'}")
    click.echo(f"report:   {folder.report / 'index.html'}")


@click.command()
@scenario_argument
@workers_option
@profile_option
@click.option("--begin", type=PUBLISHED, help="A published dataset from whose searches an adaptive sampling begins.")
@click.option("--map", "earlier", type=PUBLISHED, help="With --begin: a map made from it, to begin with its nodes.")
@click.pass_obj
def solve(
    workspace: Workspace,
    scenario: str,
    workers: int,
    profile_file: Path | None,
    begin: Path | None,
    earlier: Path | None,
) -> None:
    """Solve every task of SCENARIO that is not stored yet.

    The workers are processes of this machine; with --profile they are jobs of a cluster, driven from here. Stop it
    with Ctrl-C; the same command goes on where it stopped.

    \b
    Example: gaitflow solve quickstart --workers 2
    """
    from gaitflow.certificate.draw import EmptyDomain
    from gaitflow.config.cluster import load_profile
    from gaitflow.dataset.collect import NotComplete
    from gaitflow.execute.drivers import DriverAlive
    from gaitflow.execute.run import RunFailed
    from gaitflow.execute.schedulers.base import SchedulerError

    if earlier is not None and begin is None:
        raise click.UsageError("--map needs --begin, the dataset that the map was made from or a later version of it")
    with bad_input(), refused_artifact():
        resolved = workspace.scenario(scenario)
        warn_of_training(resolved)
        try:
            profile = None if profile_file is None else load_profile(profile_file)
            state, path = stages.solve(workspace, resolved, workers, profile, begin, earlier)
        except (RunFailed, NotComplete, DriverAlive, SchedulerError, EmptyDomain) as error:
            fail(str(error))
    click.echo(f"{state.solved} units solved, {state.failed} given up: {path}")


@click.command()
@scenario_argument
@click.pass_obj
def label(workspace: Workspace, scenario: str) -> None:
    """Label every task of SCENARIO with the gait that costs least.

    \b
    Example: gaitflow label quickstart
    """
    with bad_input():
        resolved = workspace.scenario(scenario)
        labels = stages.label(workspace, resolved)
    counts = labels.loc[labels["status"] == "solved", "gait"].value_counts()
    for gait, count in counts.items():
        click.echo(f"{count:5d}  {gait}")
    for status in ("infeasible", "failed"):
        click.echo(f"{int((labels['status'] == status).sum()):5d}  {status}")


@click.command()
@scenario_argument
@workers_option
@json_option
@click.pass_obj
def atlas(workspace: Workspace, scenario: str, workers: int, as_json: bool) -> None:
    """Build the atlas of SCENARIO.

    The atlas predicts costs, and starts of plans. It has solved tasks of every gait; this command solves many of them
    between those of the grid.

    \b
    Example: gaitflow atlas quickstart --workers 2
    """
    with bad_input():
        data = stages.atlas(workspace, workspace.scenario(scenario), workers)
    if as_json:
        return print_json(data)
    for pattern, nodes in data["nodes"].items():
        click.echo(f"{nodes:6d} nodes  {pattern}")
    judged = data["predictions"]
    mean = "none" if judged["iterations_mean"] is None else f"{judged['iterations_mean']:.1f}"
    click.echo(
        f"{judged['converged']} of {judged['tasks']} predictions at other tasks led to the optimum, iterations: {mean}"
    )
    click.echo(f"{data['solves']} solves, {data['modes']} modes, {data['bytes'] / 1e6:.1f} MB")


@click.command()
@scenario_argument
@click.option("--constant", is_flag=True, help="Accept that all tasks have the same gait; the map is constant then.")
@json_option
@click.pass_obj
def train(workspace: Workspace, scenario: str, constant: bool, as_json: bool) -> None:
    """Train the classifiers of SCENARIO and keep the best.

    They are compared by cross-validation; the output states the rule.

    \b
    Example: gaitflow train quickstart
    """
    from gaitflow.learn.classifier import CannotTrain

    with bad_input():
        resolved = workspace.scenario(scenario)
        try:
            data = stages.train(workspace, resolved, constant)
        except CannotTrain as error:
            fail(f"{resolved.name}: {error}")
    if as_json:
        return print_json(data)
    for row in data["competitors"]:
        mark = "*" if row["method"] == data["method"] else " "
        click.echo(f"{mark} {row['method']:8} folds:    {quality(row['cross_validation'])}")
        click.echo(f"  {'':8} held out: {quality(row['held_out'])}")
    click.echo(f"the method marked * is published; the rule: {data['rule']}")
    click.echo(f"picks of the map, by its atlas: held out {quality(data['published']['map_held_out'])}")
    for remark in data["remarks"]:
        click.echo(remark)


@click.command()
@scenario_argument
@click.option("--version", help="Publish under this version, such as 1.0.0; by default the next free one.")
@click.option("--force", is_flag=True, help="Publish even a map beyond its scenario's limits; its card says so.")
@json_option
@click.pass_obj
def publish(workspace: Workspace, scenario: str, version: str | None, force: bool, as_json: bool) -> None:
    """Publish the dataset and the map of SCENARIO.

    A published version never changes. A map whose regret, infeasible picks or certificate are beyond the limits of its
    scenario is refused.

    \b
    Example: gaitflow publish quickstart
    """
    from gaitflow.publishing import PublishError

    with bad_input():
        resolved = workspace.scenario(scenario)
        try:
            done = stages.publish(workspace, resolved, version, force)
        except PublishError as error:
            fail(str(error))
    for remark in done.remarks:
        click.echo(f"gaitflow: {remark}", err=True)
    if as_json:
        return print_json({"version": done.version, "dataset": str(done.dataset), "model": str(done.model)})
    click.echo(f"{done.model}\n{done.dataset}")


@click.command()
@click.argument("scenario", required=False)
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    help="Where the report of a published folder goes.",
)
@click.option("--claims", is_flag=True, help="Measure the paper's statements of section IV.A on the published labels.")
@click.option("--exact-motion", is_flag=True, help="Write docs/results/exact-motion.md: maps of Euler and exact ones.")
@click.option("--sweep", help="Write docs/results/sweep-SWEEP.md: the statements on all robots of this sweep.")
@json_option
@click.pass_obj
def report(
    workspace: Workspace,
    scenario: str | None,
    output: Path | None,
    claims: bool,
    exact_motion: bool,
    sweep: str | None,
    as_json: bool,
) -> None:
    """Draw the report of a map, or check the paper's claims.

    The report has the map, its gaits and motions, as PNG files and one HTML page. SCENARIO is one that was run here, or
    the folder of a published map or dataset. For a folder nothing is solved, and the report goes to
    runs/<scenario>/report-<version>.

    \b
    Example: gaitflow report quickstart
             gaitflow report models/anymal-energy --output anymal-report
             gaitflow report --claims
             gaitflow report --sweep half-cheetah
    """
    if [scenario is not None, claims, exact_motion, sweep is not None].count(True) != 1:
        raise click.UsageError("give a SCENARIO to draw, or --claims, --exact-motion or --sweep without one")
    with bad_input(), refused_artifact():
        if exact_motion:
            from gaitflow.report.exact_motion import write_exact_motion

            written = write_exact_motion(workspace.datasets, workspace.root / "docs")
            return print_json([str(path) for path in written]) if as_json else click.echo("\n".join(map(str, written)))
        if claims:
            from gaitflow.report.claims import claims_data, claims_markdown

            found = published.claims(workspace)
            shares = shares_of_robots(workspace)
            return print_json(claims_data(found)) if as_json else click.echo(claims_markdown(found, shares), nl=False)
        if sweep is not None:
            written = sweep_report(workspace, workspace.sweep(sweep))
            return print_json([str(path) for path in written]) if as_json else click.echo("\n".join(map(str, written)))
        paths = _drawn(workspace, str(scenario), output)
    return print_json([str(path) for path in paths]) if as_json else click.echo("\n".join(map(str, paths)))


def _drawn(workspace: Workspace, scenario: str, output: Path | None) -> list[Path]:
    """The files of the report of a folder or address when it is one, else of the run of a scenario."""
    folder = local_folder(scenario)
    if folder.is_dir():
        return published.report_published(workspace, folder, output)
    if output is not None:
        raise ConfigError(f"--output {output}: {scenario} is no folder of a map or dataset; a run's report is in runs/")
    return stages.report(workspace, workspace.scenario(scenario))


def quality(data: dict[str, Any]) -> str:
    """One line of a method's numbers."""
    if not data["tasks"]:
        return "no tasks"
    regret = "no regret known" if data["regret_mean"] is None else f"regret {data['regret_mean']:.3%}"
    return (
        f"accuracy {data['accuracy']:.3f} F1 {data['macro_f1']:.3f} {regret} infeasible {data['infeasible_rate']:.3f}"
    )
