"""A scenario over sampled robots, from files to files: one store of units, one table of labels."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gaitflow.config.scenario import Scenario
from gaitflow.config.sweep import Sample, Sweep, sampled
from gaitflow.files import atomic_write, make_folder
from gaitflow.pipeline.json_file import read_json, write_json
from gaitflow.pipeline.workspace import Workspace

if TYPE_CHECKING:
    import pandas as pd

    from gaitflow.config.cluster import Profile
    from gaitflow.dataset.sweep import SweepTable
    from gaitflow.execute.status import RunStatus
    from gaitflow.report.sweep_page import RuleOfMotion, SweepResult
    from gaitflow.store.units import Unit

PAPERS = "half-cheetah"  # the sweep whose shares stand beside the paper's statements


def sweep_units(samples: tuple[Sample, ...]) -> tuple[Unit, ...]:
    """The units of work of all robots, in their order."""
    from gaitflow.store.units import plan_units

    return tuple(unit for sample in samples for unit in plan_units(sample.scenario))


def sweep(
    workspace: Workspace, scenario: Scenario, given: Sweep, workers: int, profile: Profile | None = None
) -> pd.DataFrame:
    """Solve and label the scenario with every robot of the sweep; writes the robots and one table, which it returns.

    Units that are stored are not solved again. Raises ConfigError for a robot that cannot be, before any work starts,
    and as `drive` does.
    """
    from gaitflow.dataset.sweep import sweep_labels, write_sweep
    from gaitflow.execute.display import display
    from gaitflow.pipeline.drive import drive
    from gaitflow.store.parts import UnitStore

    samples, run = sampled(scenario, given), workspace.sweep_run(scenario.name, given)
    make_folder(run.folder)
    write_json(run.robots, [_robot(sample) for sample in samples])
    store = UnitStore(run.folder)
    with display(run.folder.name) as tell:
        drive(sweep_units(samples), store, tell, workers, profile)
    labels = sweep_labels(store, samples)
    write_sweep(run.table, scenario, given, labels)
    return labels


def sweep_status(workspace: Workspace, scenario: Scenario, given: Sweep) -> RunStatus:
    """How far a sweep is, with all its robots. Raises ConfigError as `sampled` does."""
    from gaitflow.execute.status import units_status
    from gaitflow.store.parts import UnitStore

    folder = workspace.sweep_run(scenario.name, given).folder
    return units_status(folder.name, sweep_units(sampled(scenario, given)), UnitStore(folder))


def sweep_result(workspace: Workspace, given: Sweep) -> SweepResult:
    """What the finished runs of a sweep say of the paper's statements, by each rule of motion.

    Runs of an older file of that name do not count. Raises ValueError when there is none of the paper's scenarios.
    """
    from gaitflow.report.claims import EXACT, FIGURES
    from gaitflow.report.sweep_page import SweepResult

    tables = [_tables(workspace, given, names) for names in (FIGURES, EXACT)]
    rules = [_rule(workspace, found, bool(exact)) for exact, found in enumerate(tables) if found]
    if not rules:
        some = ", ".join((*FIGURES.values(), *EXACT.values()))
        raise ValueError(
            f"{workspace.root / 'runs'}: no finished run of the sweep {given.name} over a scenario of the paper; "
            f"run `gaitflow sweep SCENARIO {given.name}` first, with one of {some}"
        )
    one = next(table for found in tables for table in found.values())
    return SweepResult(given, one.parameters[list(given.ranges)], rules)


def sweep_report(workspace: Workspace, given: Sweep) -> list[Path]:
    """Write the document of a sweep, as Markdown, JSON and a picture, into docs/results. Raises as `sweep_result`."""
    from gaitflow.report.report import png_of
    from gaitflow.report.sweep_chart import draw_sweep
    from gaitflow.report.sweep_page import sweep_data, sweep_page

    result = sweep_result(workspace, given)
    page, data, picture = (workspace.results / f"sweep-{given.name}.{kind}" for kind in ("md", "json", "png"))
    title = f"The paper's statements on {len(result.parameters)} robots"
    atomic_write(page, sweep_page(result, picture.name).encode())
    write_json(data, sweep_data(result))
    atomic_write(picture, png_of(draw_sweep(result.shares, title)))
    return [page, data, picture]


def shares_of_robots(workspace: Workspace) -> dict[str, dict[str, str]]:
    """By rule of motion and statement, how many robots of the sweep PAPERS keep it; nothing without its document."""
    from gaitflow.report.sweep_page import share_texts

    file = workspace.results / f"sweep-{PAPERS}.json"
    return share_texts(read_json(file)) if file.exists() else {}


def _tables(workspace: Workspace, given: Sweep, names: Mapping[str, str]) -> dict[str, SweepTable]:
    """The tables of this very sweep, by figure."""
    from gaitflow.dataset.sweep import read_sweep

    files = {figure: workspace.sweep_run(name, given).table for figure, name in names.items()}
    tables = {figure: read_sweep(file) for figure, file in files.items() if file.exists()}
    return {figure: table for figure, table in tables.items() if table.sweep == given}


def _rule(workspace: Workspace, tables: Mapping[str, SweepTable], exact: bool) -> RuleOfMotion:
    from gaitflow.report.claims import outcomes
    from gaitflow.report.sweep_page import RULES, RuleOfMotion
    from gaitflow.report.sweep_shares import sweep_verdicts

    labels = {figure: table.labels for figure, table in tables.items()}
    published = {figure: _published(workspace, table) for figure, table in tables.items()}
    own = outcomes({figure: found for figure, found in published.items() if found is not None}, exact)
    scenarios = {figure: table.scenario for figure, table in tables.items()}
    ours = {key: verdict for key, (verdict, _) in own.items()}
    return RuleOfMotion(RULES[exact], scenarios, sweep_verdicts(labels, exact), ours)


def _published(workspace: Workspace, table: SweepTable) -> pd.DataFrame | None:
    """The published labels of the scenario's own robot at the tasks of a sweep; None where one of them is missing."""
    from gaitflow.report.map_tasks import newest_grid

    newest = newest_grid(workspace.datasets / table.scenario.name)
    if newest is None:
        return None
    _, labels = newest
    axes = list(table.scenario.tasks.ranges)
    wanted = table.frame[axes].round(9).drop_duplicates()
    found = labels[labels["split"] == "grid"].round(dict.fromkeys(axes, 9)).merge(wanted, on=axes)
    return found if len(found) == len(wanted) else None


def _robot(sample: Sample) -> dict[str, Any]:
    return {"sample": sample.number, "values": dict(sample.values), "robot": sample.scenario.robot.as_data()}
