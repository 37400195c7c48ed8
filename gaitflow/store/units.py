"""Units of work: content-addressed slices of a scenario that a worker solves as a whole.

A unit's data are complete: problem, search strategy, tasks, restart seeds and the code that solves them. Its digest
names its file in the store, so whatever changes a solution changes the name, and nothing else does: not a scenario's
name, description, learning settings, nor how its grid was written.
"""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gaitflow.config.file import ConfigError
from gaitflow.config.scenario import Scenario
from gaitflow.config.tasks import tasks_of
from gaitflow.core.task import AXES, SPLITS, Split, Task
from gaitflow.tables.solver_code import solver_version

RESTARTS_PER_UNIT = 5  # Bonmin runs of one task that are solved together
_ENCODER = json.JSONEncoder(sort_keys=True, separators=(",", ":"), allow_nan=False)  # as `scenario.digest_of` has it


@dataclass(frozen=True)
class Unit:
    """One slice of work, of plain JSON data. Equal units have equal digests.

    problem: `Scenario.problem_data`. strategy: its settings that a solve depends on. tasks: a chain, for the grid of
    rising speed at one value of all other axes. seeds: the restarts of this slice, None when the strategy seeds
    itself. solver: {"code": digest of the solving code, "casadi": version}.

    In JSON a task has its values on the problem's `axes` and its split; on any other axis it has the default. So an
    axis that is added to the register changes no unit of a scenario that does not use it.
    """

    problem: str  # canonical JSON (so are strategy, solver), so that a unit is hashable and immutable
    strategy: str
    tasks: tuple[Task, ...]
    seeds: tuple[int, ...] | None
    solver: str

    def as_data(self) -> dict[str, Any]:
        """Plain JSON data; `from_data` is the inverse."""
        return {
            "problem": json.loads(self.problem),
            "strategy": json.loads(self.strategy),
            "tasks": self._task_data(),
            "seeds": None if self.seeds is None else list(self.seeds),
            "solver": json.loads(self.solver),
        }

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Unit:
        """Rebuild a unit. Raises ValueError when a part is missing or of another kind."""
        try:
            seeds, problem = data["seeds"], _canonical(data["problem"])
            return cls(
                problem=problem,
                strategy=_canonical(data["strategy"]),
                tasks=tuple(_task(task, _axes(problem)) for task in data["tasks"]),
                seeds=None if seeds is None else tuple(int(seed) for seed in seeds),
                solver=_canonical(data["solver"]),
            )
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"not a unit of work: {error!r}") from None

    @functools.cached_property
    def digest(self) -> str:
        """SHA-256 of the canonical JSON of `as_data`, hexadecimal: its name in the store."""
        # Put together from the texts at hand: parsing the problem again for each of 10^5 units takes most of a plan.
        seeds, tasks = _canonical(self.seeds), _canonical(self._task_data())
        text = (
            f'{{"problem":{self.problem},"seeds":{seeds},"solver":{self.solver},'
            f'"strategy":{self.strategy},"tasks":{tasks}}}'
        )
        return hashlib.sha256(text.encode()).hexdigest()

    @functools.cached_property
    def scenario(self) -> Scenario:
        """The scenario to solve: this unit's problem and strategy; its grid is the first task, its name the digest.

        Raises ValueError when they make none.
        """
        data, first = self.as_data(), self.tasks[0]
        problem = {key: value for key, value in data["problem"].items() if key != "axes"}
        # A range of one value says that the axis is one of the problem's parameters, whatever its value is here.
        axes = {axis: {"start": first[axis], "stop": first[axis], "count": 1} for axis in _axes(self.problem)}
        name = f"unit-{self.digest[:12]}"
        try:
            return Scenario.from_data(
                {"name": name, "tasks": {"axes": axes}, "strategy": data["strategy"], **problem}, name
            )
        except ConfigError as error:
            raise ValueError(f"not a unit of work: {error}") from None

    def _task_data(self) -> list[dict[str, Any]]:
        axes = _axes(self.problem)
        return [{axis: task[axis] for axis in axes} | {"split": task.split} for task in self.tasks]


def plan_units(scenario: Scenario, chosen: Sequence[Task] | None = None) -> tuple[Unit, ...]:
    """Cut a scenario's tasks, or those that were chosen, into units, in their order.

    Every task (and restart seed) is in exactly one.

    All but `bonmin`: chains of `tasks_per_unit` neighbouring speeds at one value of every other axis, so that a task
    starts from its neighbour's solution (where the speed is fixed, neighbours on the first axis with a range);
    held-out tasks in chains as they are sorted. Tasks of an adaptive sampling are units of their own, so that each is
    searched without knowing of others. `bonmin`: one task and 5 restarts, with the seeds strategy.seed,
    seed + 1, ..., so that asking for more restarts keeps the units solved before.
    """
    problem = _canonical(scenario.problem_data)
    strategy = scenario.strategy.model_dump(mode="json", exclude={"tasks_per_unit"})
    solver = _canonical(solver_version())
    if scenario.strategy.name == "bonmin":
        slices = list(_seed_slices(scenario.strategy.seed, scenario.strategy.restarts))
        return tuple(
            Unit(
                problem,
                _canonical(strategy | {"restarts": len(seeds), "seed": seeds[0]}),
                (task,),
                seeds,
                solver,
            )
            for task in tasks_of(scenario)
            for seeds in slices
        )
    text = _canonical(strategy)
    if scenario.tasks.adaptive is not None:
        return plan_cold(scenario, tasks_of(scenario) if chosen is None else chosen)
    along = next(iter(scenario.tasks.ranges))
    chains = _chains(tasks_of(scenario), along, scenario.strategy.tasks_per_unit)
    return tuple(Unit(problem, text, chain, None, solver) for chain in chains)


def plan_cold(scenario: Scenario, tasks: Sequence[Task]) -> tuple[Unit, ...]:
    """A unit a task: so each is searched without knowing of the others."""
    strategy = scenario.strategy.model_dump(mode="json", exclude={"tasks_per_unit"})
    problem, text, solver = _canonical(scenario.problem_data), _canonical(strategy), _canonical(solver_version())
    return tuple(Unit(problem, text, (task,), None, solver) for task in tasks)


def plan_exhaustive(scenario: Scenario, incumbents: Mapping[Task, float], parts: int) -> tuple[Unit, ...]:
    """Units that together try every pattern of each task that is not sure to cost more than its incumbent.

    `incumbents` gives the unscaled cost of a known motion a task, `parts` how many units a task is cut into.
    """
    problem, solver = _canonical(scenario.problem_data), _canonical(solver_version())
    own = scenario.strategy.model_dump(mode="json", exclude={"tasks_per_unit"})
    strategy = own | {"name": "patterns", "pattern": None}
    return tuple(
        Unit(problem, _canonical(strategy | {"part": [part, parts], "incumbent": cost}), (task,), None, solver)
        for task, cost in incumbents.items()
        for part in range(parts)
    )


def _chains(tasks: Sequence[Task], along: str, length: int) -> Iterator[tuple[Task, ...]]:
    """Tasks that differ on the axis `along` only, `length` at most; of those held out, in their order."""
    chains: dict[tuple[float, ...], list[Task]] = {}
    for task in tasks:
        others = task.on(axis for axis in AXES if axis != along) if task.split == "grid" else ()
        chains.setdefault(others, []).append(task)
    for chain in chains.values():
        yield from (tuple(chain[i : i + length]) for i in range(0, len(chain), length))


def _seed_slices(first: int, count: int) -> Iterable[tuple[int, ...]]:
    seeds = range(first, first + count)
    return (tuple(seeds[i : i + RESTARTS_PER_UNIT]) for i in range(0, count, RESTARTS_PER_UNIT))


def _canonical(data: Any) -> str:
    return _ENCODER.encode(data)


@functools.lru_cache(maxsize=64)
def _axes(problem: str) -> tuple[str, ...]:
    """The axes of a problem, given its JSON: units of one scenario share that text, and there may be 10^5 of them."""
    axes = json.loads(problem)["axes"]
    if not isinstance(axes, list) or not all(axis in AXES for axis in axes) or len(set(axes)) < len(axes):
        raise ValueError("the problem's axes are not among those of a task")
    return tuple(axes)


def _task(data: Mapping[str, Any], axes: Sequence[str]) -> Task:
    if set(data) != {*axes, "split"}:
        raise ValueError(f"a task has {sorted(data)}, expected {[*axes, 'split']}")
    return Task.of({axis: float(data[axis]) for axis in axes}, _split(data["split"]))


def _split(text: Any) -> Split:
    if text not in SPLITS:
        raise ValueError(f"split {text!r}; allowed are {', '.join(SPLITS)}")
    split: Split = text
    return split
