"""A scenario in a few sentences."""

from __future__ import annotations

from gaitflow.config.axes import Tasks
from gaitflow.config.scenario import Scenario
from gaitflow.core.task import AXES
from gaitflow.report import axis_text
from gaitflow.report.tables import number, percent


def scenario_text(scenario: Scenario) -> tuple[str, ...]:
    """Paragraphs on its robot, its objective, how motions are cut into steps, its tasks and its search."""
    robot, settings, tasks = scenario.robot, scenario.transcription, scenario.tasks
    weights = {name.replace("_", " "): weight for name, weight in scenario.objective.as_data().items() if weight}
    stances = "any number of stances" if scenario.stances_per_leg is None else "one stance"
    # The ground is always told, of the other axes only what is not as usual.
    fixed = [
        f"{axis_text.words(axis)} {axis_text.quantity(axis, value)}"
        for axis, value in _fixed(scenario).items()
        if axis in ("slope", "friction") or value != AXES[axis].default
    ]
    return (
        f"Robot {robot.name}: {number(robot.mass)} kg, {len(robot.legs)} legs ({', '.join(robot.leg_names)}), "
        f"{robot.dimension}D.",
        "Objective, weight by term: " + ", ".join(f"{name} {weight:g}" for name, weight in weights.items()) + ".",
        f"{settings.phases} phases of {settings.knots_per_phase} knots, integrated by "
        f"{settings.integrator.replace('_', '-')} with {settings.forces} forces, "
        f"each phase at least {percent(settings.min_phase_fraction)} of the cycle; {stances} a leg and cycle.",
        f"Tasks: {_tasks_text(tasks)}. "
        + (f"The same for all: {', '.join(fixed)}. " if fixed else "")
        + f"Search: {scenario.strategy.name}.",
    )


def _tasks_text(tasks: Tasks) -> str:
    ranges = {
        axis: f"{axis_text.words(axis)} from {values.start:g} to {axis_text.quantity(axis, values.stop)}"
        for axis, values in tasks.ranges.items()
    }
    if tasks.adaptive is None:
        grid = " by ".join(f"{values.count} values of {ranges[axis]}" for axis, values in tasks.ranges.items())
        return f"{grid}, and {tasks.held_out} held-out tasks between"
    grid = " by ".join(str(values.count) for values in tasks.ranges.values())
    return f"chosen by the map, anywhere with {', '.join(ranges.values())}; its domain is told by a grid of {grid}"


def _fixed(scenario: Scenario) -> dict[str, float]:
    """The values of the axes without a range."""
    space = scenario.tasks.space
    given = dict(space.fixed)
    return {
        name: given.get(name, axis.default or 0.0)
        for name, axis in AXES.items()
        if name not in space.ranged and not (axis.spatial and scenario.robot.dimension == 2)
    }
