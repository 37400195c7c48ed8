"""Where two maps of one robot take different gaits, and what it costs to take the other's."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

from gaitflow.atlas.patterns import map_symmetry
from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern, Symmetry, gait_of
from gaitflow.core.task import AXES
from gaitflow.report.predicted import known_gaits
from gaitflow.runtime import GaitMap
from gaitflow.runtime.artifact import Artifact
from gaitflow.runtime.manifest import Manifest


@dataclass(frozen=True)
class Disagreement:
    """A task at which two maps take different gaits.

    `first_excess` is how much dearer the second map's gait is than the first's own, by the first map's atlas, as a
    share; `second_excess` the same the other way round. None where that atlas knows no motion of the other's gait.
    """

    task: Mapping[str, float]
    first: str
    second: str
    first_excess: float | None
    second_excess: float | None


@dataclass(frozen=True)
class MapDifference:
    """How two maps compare at the grid tasks of both.

    `tasks` is at how many both answer; `only_first` and `only_second` at how many one of them alone does. `gaits` are
    the gaits that one map has and the other lacks.
    """

    tasks: int
    only_first: int
    only_second: int
    disagreements: tuple[Disagreement, ...]
    gaits_first: tuple[str, ...]
    gaits_second: tuple[str, ...]


def map_difference(first: Artifact, second: Artifact) -> MapDifference:
    """Compare two maps at the grid tasks of both, on the axes that either ranges over.

    An axis that one map holds at one value is held there. Gaits are the same, however a version calls them, when they
    are by the symmetry of either map: one may tell from another what the other map takes for its mirror image. Raises
    ValueError for maps of robots with other legs, and when no task belongs to both.
    """
    _check_legs(first.manifest, second.manifest)
    maps, counts = (GaitMap(first), GaitMap(second)), {"tasks": 0, "first": 0, "second": 0}
    of_first, of_second = (_Keys.of(artifact.manifest) for artifact in (first, second))
    disagreements = []
    for task in _tasks(first.manifest, second.manifest):
        asked: list[dict[str, Any]] = [{axis: task[axis] for axis in gait_map.axes} for gait_map in maps]
        choices = [gait_map.select(**values) for gait_map, values in zip(maps, asked, strict=True)]
        gaits = [choice.gait for choice in choices]
        if gaits[0] is None or gaits[1] is None:
            counts["first"] += gaits[0] is not None
            counts["second"] += gaits[1] is not None
            continue
        counts["tasks"] += 1
        patterns = [_pattern(gait_map.manifest, str(gait)) for gait_map, gait in zip(maps, gaits, strict=True)]
        if not of_first.same(*patterns) and not of_second.same(*patterns):
            dearer = (
                _excess(first, of_first, asked[0], *patterns),
                _excess(second, of_second, asked[1], *patterns[::-1]),
            )
            disagreements.append(Disagreement(task, gaits[0], gaits[1], *dearer))
    if not any(counts.values()):
        raise ValueError(f"{_named(first.manifest)} and {_named(second.manifest)}: neither answers at a task of both")
    return MapDifference(
        counts["tasks"],
        counts["first"],
        counts["second"],
        tuple(disagreements),
        tuple(_lacking(first.manifest, second.manifest, of_first)),
        tuple(_lacking(second.manifest, first.manifest, of_second)),
    )


def _check_legs(first: Manifest, second: Manifest) -> None:
    legs = [[leg["name"] for leg in manifest.scenario["robot"]["legs"]] for manifest in (first, second)]
    if legs[0] != legs[1]:
        raise ValueError(
            f"{_named(first)} has the legs {', '.join(legs[0])}, {_named(second)} {', '.join(legs[1])}: "
            "their gaits cannot be compared"
        )


def _tasks(first: Manifest, second: Manifest) -> Iterator[dict[str, float]]:
    """The grid tasks of both maps, on the axes that either ranges over; none where an axis has no common value."""
    axes = [axis for axis in AXES if axis in first.domain.axes or axis in second.domain.axes]
    values = {axis: _values(axis, first, second) for axis in axes}
    return (dict(zip(axes, place, strict=True)) for place in product(*values.values()))


def _values(axis: str, first: Manifest, second: Manifest) -> list[float]:
    own = [manifest.domain.axes.get(axis) or (_held(axis, manifest),) for manifest in (first, second)]
    low, high = (max(each[0] for each in own), min(each[-1] for each in own))
    held = [each[0] for each in own if len(each) == 1]
    return sorted({value for each in own for value in each if low <= value <= high and value in (held or each)})


def _held(axis: str, manifest: Manifest) -> float:
    value = dict(manifest.space.fixed).get(axis, AXES[axis].default)
    return float("nan") if value is None else value


def _pattern(manifest: Manifest, gait: str) -> str:
    return next(each.pattern for each in manifest.gaits if each.name == gait)


@dataclass(frozen=True)
class _Keys:
    """The canonical text of the gait that a pattern realises, by the symmetry of one map."""

    symmetry: Symmetry

    @classmethod
    def of(cls, manifest: Manifest) -> _Keys:
        return cls(map_symmetry(Scenario.from_data(dict(manifest.scenario), _named(manifest))))

    def __call__(self, pattern: str) -> str:
        return gait_of(Pattern.from_text(pattern), self.symmetry).text

    def same(self, pattern: str, other: str) -> bool:
        return self(pattern) == self(other)


def _excess(judge: Artifact, keys: _Keys, task: Mapping[str, float], own: str, other: str) -> float | None:
    """How much dearer another gait is than a map's own, by its atlas; None where that does not know both."""
    costs = {keys(one.pattern): one.cost for one in known_gaits(judge, task)}
    if keys(own) not in costs or keys(other) not in costs:
        return None
    return costs[keys(other)] / costs[keys(own)] - 1


def _lacking(manifest: Manifest, other: Manifest, keys: _Keys) -> Iterator[str]:
    """The gaits of a map that the other one lacks, by the symmetry of `keys`."""
    theirs = {keys(gait.pattern) for gait in other.gaits}
    return (gait.name for gait in manifest.gaits if keys(gait.pattern) not in theirs)


def _named(manifest: Manifest) -> str:
    return f"{manifest.name} {manifest.version}"
