"""A scenario over sampled robots, from files to files: one store of units, one table of labels."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gaitflow.config.scenario import Scenario
from gaitflow.config.sweep import Sample, Sweep, sampled
from gaitflow.files import make_folder
from gaitflow.pipeline.workspace import Workspace

if TYPE_CHECKING:
    import pandas as pd

    from gaitflow.config.cluster import Profile
    from gaitflow.store.units import Unit


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
    from gaitflow.pipeline.drive import drive
    from gaitflow.pipeline.stages import write_json
    from gaitflow.store.parts import UnitStore

    samples, run = sampled(scenario, given), workspace.sweep_run(scenario.name, given)
    make_folder(run.folder)
    write_json(run.robots, [_robot(sample) for sample in samples])
    store = UnitStore(run.folder)
    drive(sweep_units(samples), store, run.folder.name, workers, profile)
    labels = sweep_labels(store, samples)
    write_sweep(run.table, scenario, given, labels)
    return labels


def _robot(sample: Sample) -> dict[str, object]:
    return {"sample": sample.number, "values": dict(sample.values), "robot": sample.scenario.robot.as_data()}
