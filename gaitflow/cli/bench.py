"""`gaitflow bench`: measure, and write down with machine and date what was measured."""

from __future__ import annotations

import sys
from pathlib import Path

import click

import gaitflow
from gaitflow.cli.errors import bad_input, print_json
from gaitflow.cli.options import json_option
from gaitflow.pipeline.workspace import Workspace

BENCHES = (
    "certificate", "certify", "clients", "cpp", "discovery", "drive", "faults", "hostile", "map", "mesh", "minlp",
    "online", "overhead", "phases", "ranking", "referee", "sampling", "scale", "scaling", "select", "speed", "speedup",
    "stances", "store", "table1", "table2", "walk",
)  # fmt: skip
PIPED_WIDTH = 160  # a table in a file need not fit a terminal
DEFAULT_SCENARIO = "half-cheetah-flat-effort"


@click.command()
@click.argument("name", type=click.Choice(BENCHES))
@click.option("--scenario", default=DEFAULT_SCENARIO, show_default=True)
@click.option("--tasks", type=click.IntRange(1), help="How many tasks; by default the bench's own number.")
@click.option("--seed", default=0, show_default=True)
@click.option(
    "--profile",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="Only for speedup: measure on jobs of this cluster.",
)
@json_option
@click.pass_obj
def bench(
    workspace: Workspace, name: str, scenario: str, tasks: int | None, seed: int, profile: Path | None, as_json: bool
) -> None:
    """Measure something and write docs/results/NAME-SCENARIO.json.

    A bench that was stopped goes on where it was. The benches:

    \b
    discovery  exhaustive search against Bonmin's restarts: cost and CPU time
    table1     the paper's Table I: MINLP, random starts, warm starts
    table2     the paper's Table II, with the MINLP's runs of `bench minlp` (after `gaitflow run`)
    minlp      Bonmin for an hour on one task, its incumbents and gap, beside our search
    mesh       transcriptions and meshes: error of the best cost, wrong labels and CPU time
    referee    IPOPT on random patterns that were solved or given up (--tasks: how many of the solved)
    scaling    CPU time of one pattern by legs, phases and knots, for two robots (SCENARIO does not matter)
    map        what making a map took, every label checked again (after `gaitflow run`)
    select     time to load a map and to ask it for a gait
    online     planning from a map: latency, consistency, comparison with the paper's way; draws a figure
    certify    `gaitflow certify` with every task that it judged; 95 % bounds on wrong plans of a published map
    clients    whole-body shooting and predictive control from a map's plans, from a hand-made trot, and cold
    cpp        planning from an exported map in C++ (needs cmake, cc, g++)
    drive      a minute's drive in MuJoCo, commanded by speed alone: falls, switches, the loop's times
    walk       a map's picks and hand-made gaits in MuJoCo: who walks, and what it costs
    stances    what one stance per leg costs (needs the runs of SCENARIO and SCENARIO-free)
    phases     what eight phases gain over four (SCENARIO is S-eight-phases; needs its run and that of S)
    ranking    the gaits of each task by cost and what they ask of the robot (after `gaitflow solve`)
    certificate  exhaustive search of some tasks, compared with their labels (after `gaitflow label`)
    faults     kill -9 of workers and runs: is the dataset the same?
    hostile    thousands of damaged maps, configurations, datasets, URDFs, map.bin (or --tasks of each; needs g++)
    store      planning, resuming, checking and packing 10^3 to 10^5 units (or --tasks)
    overhead   what handing out a unit costs, and start-up to the first solve
    sampling   searches that a map needs: chosen where it is least sure, and on uniform grids
    scale      one driver with up to 400 workers that sleep: units a second, and what bounds them
    speed      plans of every published map beside one IPOPT solve, in Python and C++ (needs cmake, cc, g++)
    speedup    two workers compared with one on the same units, here or with --profile on Slurm
    Example: gaitflow bench select --scenario quickstart
    """
    from rich.console import Console

    _find_benchmarks()
    from benchmarks.document import summary_table, write
    from benchmarks.measure import measure
    from gaitflow.config.cluster import load_profile
    from gaitflow.files import atomic_write

    with bad_input():
        cluster = None if profile is None else load_profile(profile)
        done = measure(name, workspace, workspace.scenario(scenario), tasks, seed, cluster)
        written = [write(done, workspace.results)]
        if name == "online":
            from gaitflow.report.latency import draw_latency
            from gaitflow.report.report import png_of

            written.append(written[0].with_suffix(".png"))
            atomic_write(written[1], png_of(draw_latency(done)))
    if as_json:
        return print_json(done)
    console = Console()
    console = console if console.is_terminal else Console(width=PIPED_WIDTH)
    console.print(summary_table(done))
    for path in written:
        click.echo(path)


def _find_benchmarks() -> None:
    """Make the `benchmarks` beside this package importable; an installed package has none."""
    root = Path(gaitflow.__file__).resolve().parents[1]
    if not (root / "benchmarks" / "__init__.py").is_file():
        raise click.ClickException("benchmarks come with a checkout of gaitflow; this installation has none")
    if str(root) not in sys.path:
        sys.path.insert(0, str(root))
