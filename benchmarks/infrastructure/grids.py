"""A scenario's tasks cut down, or drawn out, to a grid of a wanted size with one task a unit of work."""

from __future__ import annotations

from collections.abc import Mapping

from gaitflow.config.scenario import Scenario

Span = tuple[float, float]


def with_grid(scenario: Scenario, counts: Mapping[str, int], spans: Mapping[str, Span] | None = None) -> Scenario:
    """The scenario with so many values on each of these axes, no task held out or chosen, and one task a unit.

    An axis runs over its range in the scenario, or over that in `spans`; one that has neither stays fixed. Any other
    axis with a range has the value at its start.
    """
    data = scenario.as_data()
    ranges = {axis: (values.start, values.stop) for axis, values in scenario.tasks.ranges.items()} | dict(spans or {})
    for axis, (start, stop) in ranges.items():
        count = counts.get(axis, 1)
        data["tasks"]["axes"][axis] = {"start": start, "stop": stop if count > 1 else start, "count": count}
    data["tasks"] = {"axes": data["tasks"]["axes"]}
    data["strategy"]["tasks_per_unit"] = 1
    return Scenario.from_data(data, scenario.name)
