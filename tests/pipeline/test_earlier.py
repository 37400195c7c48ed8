"""What earlier stages left, as later ones read it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from gaitflow.config.scenario import Range, Scenario, load_scenario
from gaitflow.config.tasks import tasks_of
from gaitflow.pipeline.earlier import domain_of
from gaitflow.pipeline.workspace import Workspace


def scenario_of(checkout: Path, **axes: Range | float) -> Scenario:
    data = load_scenario(checkout / "configs/scenarios/quickstart.yaml").as_data()
    data["tasks"]["axes"] |= {axis: each.as_data() if isinstance(each, Range) else each for axis, each in axes.items()}
    return Scenario.from_data(data, "test")


def labels_of(scenario: Scenario, infeasible: tuple[float, ...]) -> pd.DataFrame:
    """A label for every task, all solved but one; the order of rows says nothing."""
    axes = scenario.tasks.space.columns
    rows = [
        dict(zip(axes, task.on(axes), strict=True))
        | {"split": task.split}
        | {"status": "infeasible" if task.on(scenario.tasks.space.ranged) == infeasible else "solved"}
        for task in tasks_of(scenario)
    ]
    return pd.DataFrame(rows[::-1])


def test_the_domain_is_where_tasks_of_the_grid_were_solved(checkout: Path, tmp_path: Path) -> None:
    scenario = scenario_of(checkout, slope=Range(start=0.0, stop=10.0, count=2))
    ranges = scenario.tasks.ranges
    hole = (ranges["speed"].values[2], ranges["cycle_duration"].values[0], 10.0)
    domain = domain_of(Workspace(tmp_path).run(scenario), scenario, labels_of(scenario, hole))
    assert tuple(domain.axes) == ("speed", "cycle_duration", "slope")
    assert np.argwhere(~domain.feasible).tolist() == [[2, 0, 1]]


def test_a_fixed_axis_is_none_of_the_domains(checkout: Path, tmp_path: Path) -> None:
    scenario = scenario_of(checkout, cycle_duration=0.6)
    domain = domain_of(Workspace(tmp_path).run(scenario), scenario, labels_of(scenario, (9.9,)))
    assert dict(domain.axes) == {"speed": scenario.tasks.ranges["speed"].values}
    assert domain.feasible.all()
