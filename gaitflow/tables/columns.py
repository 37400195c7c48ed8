"""What the columns of published tables mean, and in which unit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import pyarrow as pa

from gaitflow.core.task import AXES

_COST = "the scenario's objective, SI"
_SCALED = "scaled by the kind of constraint"


@dataclass(frozen=True)
class Column:
    """What a column says, and its unit; "" where it has none."""

    meaning: str
    unit: str = ""


COLUMNS: Mapping[str, Column] = {
    **{axis.name: Column(axis.meaning, "" if axis.unit == "1" else axis.unit) for axis in AXES.values()},
    "split": Column("grid, or sampled: chosen where a map was unsure; held_out: a task that nothing is learnt from"),
    "pattern": Column("contacts, a row of digits a leg joined by /, a digit a phase, 1 is stance"),
    "gait": Column("solutions: the gait's canonical contacts; labels and gait_costs: its name"),
    "gait_key": Column("the gait's canonical contacts"),
    "strategy": Column("the search that tried the pattern"),
    "start": Column("where the kept solve began"),
    "seed": Column("of random starts"),
    "status": Column(
        "of a pattern: solved, infeasible, failed, screened or probed; of a task: solved, infeasible, failed"
    ),
    "solver_status": Column("the solver's own word, or why nothing was solved"),
    "cost": Column("cost on the scenario's mesh, NaN without a motion", _COST),
    "refined_cost": Column("cost of the same pattern on a finer mesh, NaN where none was asked", _COST),
    "refined_knots": Column("knots of that mesh, 0 where none was asked", "knots a phase"),
    "violation": Column("worst constraint violation by an independent check", _SCALED),
    "iterations": Column("of the solver, over all starts and meshes of the row"),
    "solves": Column("solver calls of the row"),
    "wall_s": Column("wall time of the row", "s"),
    "cpu_s": Column("CPU time of the row", "s"),
    "times": Column("the knots, from 0 to the cycle duration", "s"),
    "base": Column("base states at the knots: position, angles, velocity, angular velocity", "m, rad, m/s, rad/s"),
    "feet": Column("foot positions at the knots", "m"),
    "forces": Column("contact forces at the start of each step", "N"),
    "end_forces": Column("contact forces at the end of each phase's last step", "N"),
    "foot_velocities": Column("foot velocities, constant over a step", "m/s"),
    "durations": Column("of the phases; they add up to the cycle duration", "s"),
    "bound_multipliers": Column("multipliers of the bounds of the scaled problem, signs as CasADi's", "scaled"),
    "row_multipliers": Column("multipliers of the rows of the scaled problem, signs as CasADi's", "scaled"),
    "margin": Column("how much dearer the next gait is, inf where there is none", "share of the cost"),
    "runner_up": Column("the gait that costs second least"),
    "ties": Column("the gaits within the scenario's tie tolerance, the cheapest first"),
    "cost_error": Column("how far the costs of the two cheapest gaits are from a finer mesh's", "share of the cost"),
    "resolved": Column("whether it is sure which of the two cheapest gaits costs less, or that they tie"),
    "label": Column("the gait that is learnt: one of ties, as the neighbouring tasks have it"),
    "gap_between_knots": Column("largest distance from the continuous motion under the same forces", "m or rad"),
    "box_between_knots": Column("how far a foot leaves its box between knots", "m"),
    "friction_between_knots": Column("how far a force leaves its friction cone between knots", "weight of the robot"),
    "penetration_between_knots": Column("how far a foot sinks into the ground between knots", "m"),
    "cost_check": Column("cost over the cost integrated anew along the motion, less 1", "share of the cost"),
    "excess": Column("how much dearer the gait is than the task's cheapest", "share of the cost"),
}


def described(table: pa.Table) -> pa.Table:
    """The table with `unit` and `meaning` in the metadata of each column that is known; all else is kept."""
    fields = [field.with_metadata(dict(field.metadata or {}) | _metadata(field.name)) for field in table.schema]
    return table.cast(pa.schema(fields, table.schema.metadata))


def _metadata(name: str) -> dict[bytes, bytes]:
    column = COLUMNS.get(name)
    if column is None:
        return {}
    return {b"meaning": column.meaning.encode()} | ({b"unit": column.unit.encode()} if column.unit else {})
