"""A run as a program, for tests that stop or kill it: drive.py SCENARIO.json STORE SOLVER."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from gaitflow.config.scenario import Scenario
from gaitflow.execute.local import local_client
from gaitflow.execute.progress import progress
from gaitflow.execute.run import RunFailed, RunStopped, run_units
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import plan_units


def main(scenario_file: str, folder: str, solve: str) -> None:
    scenario = Scenario.from_data(json.loads(Path(scenario_file).read_text()), scenario_file)
    try:
        with progress(scenario.name) as on_event:
            run_units(plan_units(scenario), UnitStore(Path(folder)), local_client, on_event, solve=solve)
    except (RunStopped, RunFailed) as error:
        sys.exit(f"{type(error).__name__}: {error}")


if __name__ == "__main__":
    main(*sys.argv[1:])
