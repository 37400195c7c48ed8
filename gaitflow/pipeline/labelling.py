"""The labels of a run's tasks, as files."""

from __future__ import annotations

import io
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from gaitflow.config.scenario import Scenario
from gaitflow.config.tasks import tasks_of
from gaitflow.dataset import load_solutions
from gaitflow.dataset.gaps import with_motion_checks
from gaitflow.dataset.labels import gait_costs, label_tasks, mark_failed
from gaitflow.files import atomic_write
from gaitflow.pipeline.workspace import Run
from gaitflow.tables.columns import described


def write_labels(run: Run, scenario: Scenario) -> pd.DataFrame:
    """Label every task of a run's solutions; writes the labels, which are returned, and the gaits' costs."""
    solutions = load_solutions(run.solutions)
    costs = gait_costs(solutions.frame(), scenario.robot.leg_names)
    knots = scenario.transcription.knots_per_phase
    tasks = tasks_of(scenario) if scenario.tasks.adaptive is None else solutions.tasks()
    labels = label_tasks(costs, tasks, scenario.learning.tie_tolerance, knots)
    labels = with_motion_checks(mark_failed(labels, solutions.frame()), solutions)
    _write_table(run.gait_costs, costs)
    _write_table(run.labels, labels)
    return labels


def _write_table(path: Path, frame: pd.DataFrame) -> None:
    buffer = io.BytesIO()
    pq.write_table(described(pa.Table.from_pandas(frame, preserve_index=False)), buffer)
    atomic_write(path, buffer.getvalue())
