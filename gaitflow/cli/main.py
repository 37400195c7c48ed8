"""The command line. Every command is a few lines over the library; exit codes: 0 done, 1 failed, 2 bad input."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

try:
    import click

    from gaitflow.cli.bench import bench
    from gaitflow.cli.cluster import cancel, doctor, submit
    from gaitflow.cli.compact import compact
    from gaitflow.cli.errors import bad_input, fail, print_json
    from gaitflow.cli.export import export
    from gaitflow.cli.robot import robot
    from gaitflow.cli.show import show
    from gaitflow.config.file import ConfigError
    from gaitflow.pipeline import stages
    from gaitflow.pipeline.snakemake import PROFILE, run_workflow
    from gaitflow.pipeline.workspace import Workspace
except ImportError as error:
    sys.exit(f'gaitflow: the command line needs more than the runtime ({error}): pip install "gaitflow[all]"')

scenario_argument = click.argument("scenario")
json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON document and nothing else.")
profile_option = click.option(
    "--profile",
    "profile_file",
    envvar=PROFILE,
    type=click.Path(dir_okay=False, path_type=Path),
    help="Solve on the jobs of a Slurm cluster instead, such as slurm/profiles/centre-48h.yaml.",
)
workers_option = click.option("--workers", default=2, show_default=True, type=click.IntRange(1, 1024))


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="gaitflow")
@click.option(
    "--root",
    default=".",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="The folder with configs/; runs/, datasets/ and models/ grow beside it.",
)
@click.pass_context
def main(context: click.Context, root: Path) -> None:
    """Learn which gait a legged robot should use, and hand the answer to its planner.

    \b
    Example: gaitflow run quickstart
             gaitflow plan models/quickstart --speed 0.9 --cycle 0.6
    """
    context.obj = Workspace(root)


@main.command()
@scenario_argument
@workers_option
@profile_option
@click.option("--dry-run", is_flag=True, help="Say which stages would run, and run none.")
@click.pass_obj
def run(workspace: Workspace, scenario: str, workers: int, profile_file: Path | None, dry_run: bool) -> None:
    """Do all stages of SCENARIO that are not up to date: solve, label, train, publish, report.

    With --profile the workers that solve are Slurm jobs; the other stages run here.

    \b
    Example: gaitflow run quickstart
    """
    from gaitflow.config.cluster import load_profile

    with bad_input():
        resolved = workspace.scenario(scenario)
        if profile_file is not None:
            load_profile(profile_file)
        if not run_workflow(workspace, resolved.name, workers, dry_run, profile_file):
            fail(f"the workflow of {resolved.name} did not finish; what is done is kept, the same command goes on")
    if dry_run:
        return
    from gaitflow.runtime import GaitMap

    folder = workspace.run(resolved)
    published = stages.read_json(folder.published)
    gait_map = GaitMap.load(published["model"])
    speeds, cycles = gait_map.manifest.domain.speeds, gait_map.manifest.domain.cycle_durations
    v, t = speeds[len(speeds) // 2], cycles[len(cycles) // 2]
    choice = gait_map.select(v, t)
    click.echo(f"map:      {published['model']}")
    click.echo(f"dataset:  {published['dataset']}")
    click.echo(
        f"query:    {v:g} m/s, {t:g} s -> {choice.gait} ({choice.pattern}), probability {choice.probability:.2f}"
    )
    click.echo(f"picture:  {folder.report / 'map.png'}")
    click.echo(f"report:   {folder.report / 'index.html'}")


@main.command()
@scenario_argument
@workers_option
@profile_option
@click.pass_obj
def solve(workspace: Workspace, scenario: str, workers: int, profile_file: Path | None) -> None:
    """Solve every task of SCENARIO that is not stored yet, on WORKERS processes of this machine.

    With --profile the workers are Slurm jobs, driven from here. Stop it with Ctrl-C; the same command goes on where it
    stopped.

    \b
    Example: gaitflow solve quickstart --workers 2
    """
    from gaitflow.config.cluster import load_profile
    from gaitflow.dataset.collect import NotComplete
    from gaitflow.execute.drivers import DriverAlive
    from gaitflow.execute.run import RunFailed, RunStopped
    from gaitflow.execute.schedulers.jobs import SlurmError

    with bad_input():
        resolved = workspace.scenario(scenario)
        try:
            profile = None if profile_file is None else load_profile(profile_file)
            state, path = stages.solve(workspace, resolved, workers, profile)
        except (RunFailed, RunStopped, NotComplete, DriverAlive, SlurmError) as error:
            fail(str(error))
    click.echo(f"{state.solved} units solved, {state.failed} given up: {path}")


@main.command()
@scenario_argument
@json_option
@click.pass_obj
def status(workspace: Workspace, scenario: str, as_json: bool) -> None:
    """Say how far the run of SCENARIO is: while it runs, after it, and without it.

    \b
    Example: gaitflow status quickstart --json
    """
    from gaitflow.execute.status import run_status
    from gaitflow.store.parts import UnitStore

    with bad_input():
        resolved = workspace.scenario(scenario)
        state = run_status(resolved, UnitStore(workspace.run(resolved).folder))
    if as_json:
        return print_json(state.as_data())
    left = "unknown" if state.cpu_hours_left is None else f"{state.cpu_hours_left:.3f}"
    click.echo(
        f"{state.scenario}: {state.units} units: {state.solved} solved, {state.failed} failed, {state.left} left"
    )
    click.echo(f"CPU hours: {state.cpu_hours_spent:.3f} spent, {left} left; {state.quarantined} files in quarantine")
    if state.jobs is not None:
        click.echo(f"jobs: {state.jobs}")
    if state.logs is not None:
        click.echo(f"logs: {state.logs}")
    for attempt in state.errors:
        click.echo(f"  {attempt}")


@main.command()
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


@main.command()
@click.argument("dataset", type=click.Path(exists=True, path_type=Path))
@json_option
def labels(dataset: Path, as_json: bool) -> None:
    """Print the labels of a published DATASET (a version's folder): the best gait of each task.

    \b
    Example: gaitflow labels datasets/quickstart/1.0.0 --json
    """
    with bad_input():
        rows = stages.read_labels(dataset)
    if as_json:
        return print_json(rows)
    for row in rows:
        cost = row["status"] if row["cost"] is None else f"{row['gait']} {row['pattern']} cost {row['cost']:.6g}"
        click.echo(f"{row['speed']:6.3f} m/s {row['cycle_duration']:6.3f} s  {cost}")


@main.command()
@scenario_argument
@json_option
@click.pass_obj
def atlas(workspace: Workspace, scenario: str, as_json: bool) -> None:
    """Solve SCENARIO's gaits at many tasks between those of its grid, so that plans start from a prediction.

    \b
    Example: gaitflow atlas quickstart
    """
    with bad_input():
        data = stages.atlas(workspace, workspace.scenario(scenario))
    if as_json:
        return print_json(data)
    for pattern, nodes in data["nodes"].items():
        click.echo(f"{nodes:6d} nodes  {pattern}")
    for row in data["predictors"]:
        click.echo(
            f"{row['iterations_mean']:6.2f} iterations from {row['predictor']} with {row['modes']} modes, "
            f"{row['converged']} of {row['tasks']} converged"
        )
    click.echo(f"{data['solves']} solves, {data['modes']} modes published")


@main.command()
@scenario_argument
@click.option("--constant", is_flag=True, help="Where all tasks have one gait, make the constant map of it.")
@json_option
@click.pass_obj
def train(workspace: Workspace, scenario: str, constant: bool, as_json: bool) -> None:
    """Train and cross-validate the classifiers of SCENARIO and keep the best by the stated rule.

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
    click.echo(f"published is the one marked *: {data['rule']}")
    for remark in data["remarks"]:
        click.echo(remark)


@main.command()
@scenario_argument
@click.option("--version", help="Publish under this version, such as 1.0.0; by default the next free one.")
@json_option
@click.pass_obj
def publish(workspace: Workspace, scenario: str, version: str | None, as_json: bool) -> None:
    """Publish the dataset and the map of SCENARIO as a version that never changes.

    \b
    Example: gaitflow publish quickstart
    """
    from gaitflow.publishing import PublishError
    from gaitflow.publishing.dataset import DatasetExists

    with bad_input():
        resolved = workspace.scenario(scenario)
        try:
            done = stages.publish(workspace, resolved, version)
        except (PublishError, DatasetExists) as error:
            fail(str(error))
    if as_json:
        return print_json({"version": done.version, "dataset": str(done.dataset), "model": str(done.model)})
    click.echo(f"{done.model}\n{done.dataset}")


@main.command()
@click.argument("artifact", type=click.Path(path_type=Path))
@click.option("--speed", type=float, required=True, help="Forward speed v [m/s].")
@click.option("--cycle", type=float, required=True, help="Cycle duration T [s].")
@click.option("--beyond", is_flag=True, help="Plan also outside the map's domain; the motion is checked all the same.")
@json_option
def plan(artifact: Path, speed: float, cycle: float, beyond: bool, as_json: bool) -> None:
    """Ask the map ARTIFACT for a gait and refine it into a feasible motion.

    ARTIFACT is a version's folder or its parent (the newest version then).

    \b
    Example: gaitflow plan models/quickstart --speed 0.9 --cycle 0.6 --json
    """
    from gaitflow.runtime import ArtifactError, GaitMap, OutOfDomain

    with bad_input():
        try:
            answer = GaitMap.load(artifact).plan(speed, cycle, beyond=beyond)
        except OutOfDomain as error:
            if as_json:
                print_json(stages.refused_data())
            fail(f"{error}{'' if beyond else '; --beyond plans all the same'}")
        except ArtifactError as error:
            raise ConfigError(str(error)) from None
    if as_json:
        print_json(stages.plan_data(answer))
    else:
        if not answer.in_domain:
            click.echo(f"outside the map's domain, {answer.distance:.1f} steps of its grid from the nearest task")
        click.echo(f"gait:        {answer.gait} ({answer.pattern}), probability {answer.probability:.2f}")
        click.echo(f"durations:   {', '.join(f'{d:.4f}' for d in answer.durations)} s")
        click.echo(f"cost:        {answer.cost:.6g}")
        click.echo(f"feasible:    {'yes' if answer.feasible else 'no'}, worst violation {answer.violation:.1e}")
        click.echo(f"path:        {answer.path}, {answer.iterations} iterations, {answer.time_ms:.1f} ms")
    if not answer.feasible:
        sys.exit(1)


@main.command()
@click.argument("path", type=click.Path(path_type=Path))
@json_option
def verify(path: Path, as_json: bool) -> None:
    """Check a published model or dataset (a version's folder) whole: digests, contents, motions.

    \b
    Example: gaitflow verify models/quickstart/1.0.0
    """
    with bad_input():
        faults = stages.verify(path)
    if as_json:
        print_json({"path": str(path), "sound": not faults, "faults": faults})
    else:
        for fault in faults:
            click.echo(fault)
        click.echo(f"{path}: {f'{len(faults)} fault(s)' if faults else 'sound'}")
    if faults:
        sys.exit(1)


@main.command()
@scenario_argument
@json_option
@click.pass_obj
def validate(workspace: Workspace, scenario: str, as_json: bool) -> None:
    """Check the file of SCENARIO and say what it asks for.

    \b
    Example: gaitflow validate configs/scenarios/quickstart.yaml
    """
    with bad_input():
        resolved = workspace.scenario(scenario)
        data = stages.summary(resolved)
    if as_json:
        return print_json(data)
    for key, value in data.items():
        click.echo(f"{key.replace('_', ' '):16} {value}")


@main.command()
@click.argument("scenario", required=False)
@click.option("--claims", is_flag=True, help="Measure the paper's statements of section IV.A on the published labels.")
@json_option
@click.pass_obj
def report(workspace: Workspace, scenario: str | None, claims: bool, as_json: bool) -> None:
    """Draw the map of SCENARIO, its gaits and motions, as PNG and one HTML page; or check the paper's claims.

    \b
    Example: gaitflow report quickstart
             gaitflow report --claims
    """
    if claims == (scenario is not None):
        raise click.UsageError("give a SCENARIO to draw, or --claims without one")
    with bad_input():
        if claims:
            from gaitflow.report.claims import claims_data, claims_markdown

            found = stages.claims(workspace)
            return print_json(claims_data(found)) if as_json else click.echo(claims_markdown(found), nl=False)
        paths = stages.report(workspace, workspace.scenario(str(scenario)))
    return print_json([str(path) for path in paths]) if as_json else click.echo("\n".join(map(str, paths)))


def quality(data: dict[str, Any]) -> str:
    """One line of a method's numbers."""
    if not data["tasks"]:
        return "no tasks"
    regret = "no regret known" if data["regret_mean"] is None else f"regret {data['regret_mean']:.3%}"
    return (
        f"accuracy {data['accuracy']:.3f} F1 {data['macro_f1']:.3f} {regret} infeasible {data['infeasible_rate']:.3f}"
    )


main.add_command(compact)
main.add_command(cancel)
main.add_command(doctor)
main.add_command(bench)
main.add_command(export)
main.add_command(robot)
main.add_command(show)
main.add_command(submit)
