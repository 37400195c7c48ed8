"""A run on Slurm as a program, for tests that disturb it: drive.py SCENARIO.json STORE SOLVER PROFILE.yaml."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from gaitflow.config.cluster import load_profile
from gaitflow.config.scenario import Scenario
from gaitflow.execute.progress import progress
from gaitflow.execute.run import RunFailed, RunStopped, run_units
from gaitflow.execute.schedulers.cluster_client import cluster_client
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import plan_units

LONGEST_UNIT_S = 5.0


def main(scenario_file: str, folder: str, solve: str, profile_file: str) -> None:
    scenario = Scenario.from_data(json.loads(Path(scenario_file).read_text()), scenario_file)
    profile, store = load_profile(Path(profile_file)), UnitStore(Path(folder))

    def tell(note: str) -> None:
        print(note, file=sys.stderr, flush=True)

    try:
        with progress(scenario.name) as on_event:
            run_units(
                plan_units(scenario),
                store,
                lambda: cluster_client(profile, store.folder, LONGEST_UNIT_S, tell),
                on_event,
                solve=solve,
            )
    except (RunStopped, RunFailed) as error:
        sys.exit(f"{type(error).__name__}: {error}")


if __name__ == "__main__":
    main(*sys.argv[1:])
