"""What a run's store knows of tasks that were searched one by one, and of their mirror images where a map has them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import pandas as pd

from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Task
from gaitflow.dataset.mirror import MirrorImage, has_images
from gaitflow.search.solution import Solution
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import plan_cold
from gaitflow.tables.schema import scalar_columns, solution_schema
from gaitflow.tables.solutions import solutions_to_table, table_to_solutions


def scalars_of(store: UnitStore, scenario: Scenario) -> Callable[[Sequence[Task]], pd.DataFrame]:
    """Reads the scalar columns of the rows of tasks and of their images."""
    data = scenario.as_data()
    columns = scalar_columns(solution_schema(data).names)
    image = MirrorImage(scenario) if has_images(scenario) else None

    def read(tasks: Sequence[Task]) -> pd.DataFrame:
        frames = []
        for unit in plan_cold(scenario, tasks) if tasks else []:
            table = store.read(unit, columns=columns if image is None else None)
            frames.append(table.select(columns).to_pandas())
            if image is not None:
                rows = list(image.known(table_to_solutions(table, data)))
                frames.append(solutions_to_table(rows, data).select(columns).to_pandas())
        return pd.concat(frames, ignore_index=True) if frames else pd.DataFrame(columns=columns)

    return read


def motions_of(store: UnitStore, scenario: Scenario) -> Callable[[Sequence[Task]], Iterator[Solution]]:
    """Reads the solutions of tasks with their motions, and of their images without."""
    image = MirrorImage(scenario) if has_images(scenario) else None

    def read(tasks: Sequence[Task]) -> Iterator[Solution]:
        for unit in plan_cold(scenario, tasks):
            rows = list(table_to_solutions(store.read(unit), scenario.as_data()))
            yield from rows
            if image is not None:
                yield from image.known(rows)

    return read
