"""Units of work: content-addressed slices of a scenario that a worker solves as a whole.

A unit's data are complete: problem, search strategy, tasks, restart seeds and the code that solves them. Its digest
names its file in the store, so whatever changes a solution changes the name, and nothing else does: not a scenario's
name, description, learning settings, nor how its grid was written.
"""

from __future__ import annotations

import ast
import functools
import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from itertools import groupby
from pathlib import Path
from typing import Any

import gaitflow
from gaitflow.config.file import ConfigError
from gaitflow.config.scenario import Scenario
from gaitflow.config.tasks import Split, Task, tasks_of

RESTARTS_PER_UNIT = 5  # Bonmin runs of one task that are solved together
SOLVER_SOURCES = (
    "problem/*.py", "solvers/*.py", "search/*.py", "core/check.py", "core/gaits.py", "core/trajectory.py",
    "config/scenario.py", "config/robot.py",
)  # fmt: skip
_ENCODER = json.JSONEncoder(sort_keys=True, separators=(",", ":"), allow_nan=False)  # as `scenario.digest_of` has it
PROBLEM_FIELDS = ("robot", "terrain", "objective", "transcription", "stances_per_leg")


@dataclass(frozen=True)
class Unit:
    """One slice of work, of plain JSON data. Equal units have equal digests.

    problem: robot, terrain, objective, transcription, stances_per_leg. strategy: its settings that a solve depends on.
    tasks: a chain, for the grid of one T and rising speed. seeds: the restarts of this slice, None when the strategy
    seeds itself. solver: {"code": digest of the solving code, "casadi": version}.
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
            "tasks": [[task.speed, task.cycle_duration, task.split] for task in self.tasks],
            "seeds": None if self.seeds is None else list(self.seeds),
            "solver": json.loads(self.solver),
        }

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Unit:
        """Rebuild a unit. Raises ValueError when a part is missing or of another kind."""
        try:
            seeds = data["seeds"]
            return cls(
                problem=_canonical(data["problem"]),
                strategy=_canonical(data["strategy"]),
                tasks=tuple(Task(float(v), float(t), _split(split)) for v, t, split in data["tasks"]),
                seeds=None if seeds is None else tuple(int(seed) for seed in seeds),
                solver=_canonical(data["solver"]),
            )
        except (KeyError, TypeError) as error:
            raise ValueError(f"not a unit of work: {error!r}") from None

    @functools.cached_property
    def digest(self) -> str:
        """SHA-256 of the canonical JSON of `as_data`, hexadecimal: its name in the store."""
        # Put together from the texts at hand: parsing the problem again for each of 10^5 units takes most of a plan.
        seeds, tasks = _canonical(self.seeds), _canonical([[t.speed, t.cycle_duration, t.split] for t in self.tasks])
        text = (
            f'{{"problem":{self.problem},"seeds":{seeds},"solver":{self.solver},'
            f'"strategy":{self.strategy},"tasks":{tasks}}}'
        )
        return hashlib.sha256(text.encode()).hexdigest()

    @functools.cached_property
    def scenario(self) -> Scenario:
        """The scenario to solve: this unit's problem and strategy; its grid is the first task, its name the digest."""
        first, data = self.tasks[0], self.as_data()
        grid = {
            "speed": {"start": first.speed, "stop": first.speed, "count": 1},
            "cycle_duration": {"start": first.cycle_duration, "stop": first.cycle_duration, "count": 1},
        }
        name = f"unit-{self.digest[:12]}"
        settings = {"name": name, "tasks": grid, "strategy": data["strategy"], **data["problem"]}
        try:
            return Scenario.from_data(settings, name)
        except ConfigError as error:
            raise ValueError(f"not a unit of work: {error}") from None


def plan_units(scenario: Scenario) -> tuple[Unit, ...]:
    """Cut a scenario into units, in the order of its tasks; every task (and restart seed) is in exactly one.

    `patterns` and `fixed_gait`: chains of `tasks_per_unit` neighbouring speeds at one T, so that a task starts from
    its neighbour's solution; held-out tasks in chains sorted by (T, v). `bonmin`: one task and 5 restarts, with the
    seeds strategy.seed, seed + 1, ..., so that asking for more restarts keeps the units solved before.
    """
    problem = _problem_data(scenario)
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
    chains = _chains(tasks_of(scenario), scenario.strategy.tasks_per_unit)
    return tuple(Unit(problem, text, chain, None, solver) for chain in chains)


def plan_exhaustive(scenario: Scenario, incumbents: Mapping[Task, float], parts: int) -> tuple[Unit, ...]:
    """Units that together try every pattern of each task that is not sure to cost more than its incumbent.

    `incumbents` gives the unscaled cost of a known motion a task, `parts` how many units a task is cut into.
    """
    problem, solver = _problem_data(scenario), _canonical(solver_version())
    own = scenario.strategy.model_dump(mode="json", exclude={"tasks_per_unit"})
    strategy = own | {"name": "patterns", "pattern": None}
    return tuple(
        Unit(problem, _canonical(strategy | {"part": [part, parts], "incumbent": cost}), (task,), None, solver)
        for task, cost in incumbents.items()
        for part in range(parts)
    )


@functools.cache
def solver_version() -> dict[str, str]:
    """Digest of the code that solves, blind to comments, layout and docstrings, and CasADi's version.

    Read once per process: it names the code that was loaded, even when the files change while a run is on.
    """
    package = Path(gaitflow.__file__).parent
    files = sorted({path for pattern in SOLVER_SOURCES for path in package.glob(pattern)})
    try:
        casadi = version("casadi")
    except PackageNotFoundError:
        casadi = "none"
    return {"code": source_digest({str(p.relative_to(package)): p.read_text(encoding="utf-8") for p in files}),
            "casadi": casadi}  # fmt: skip


def source_digest(sources: Mapping[str, str]) -> str:
    """SHA-256 over the syntax trees of Python sources by name, without docstrings."""
    total = hashlib.sha256()
    for name in sorted(sources):
        tree = ast.parse(sources[name], filename=name)
        for node in ast.walk(tree):
            match node:
                case ast.Module() | ast.ClassDef() | ast.FunctionDef() | ast.AsyncFunctionDef():
                    if ast.get_docstring(node, clean=False) is not None:
                        node.body = node.body[1:]
        total.update(f"{name}\0{ast.dump(tree)}\0".encode())
    return total.hexdigest()


def _problem_data(scenario: Scenario) -> str:
    data = {field: scenario.as_data()[field] for field in PROBLEM_FIELDS}
    data["robot"] = {key: value for key, value in data["robot"].items() if key != "source"}  # prose, not physics
    return _canonical(data)


def _chains(tasks: Sequence[Task], length: int) -> Iterator[tuple[Task, ...]]:
    def group(task: Task) -> tuple[str, float]:
        return task.split, task.cycle_duration if task.split == "grid" else 0.0

    for _, members in groupby(tasks, key=group):
        chain = tuple(members)
        yield from (chain[i : i + length] for i in range(0, len(chain), length))


def _seed_slices(first: int, count: int) -> Iterable[tuple[int, ...]]:
    seeds = range(first, first + count)
    return (tuple(seeds[i : i + RESTARTS_PER_UNIT]) for i in range(0, count, RESTARTS_PER_UNIT))


def _canonical(data: Any) -> str:
    return _ENCODER.encode(data)


def _split(text: Any) -> Split:
    if text == "grid" or text == "held_out":
        return text
    raise ValueError(f"not a unit of work: split {text!r}; allowed are grid, held_out")
