"""The stage `solve` of a scenario that chooses its own tasks: rounds of searches until the map's certificate is good.

What was chosen is written down before it is searched, and a round's searches are units of the run's store. So an
interrupted sampling repeats its rounds from the store, without a search, and goes on in the one that it was in.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from gaitflow.atlas.node import Each
from gaitflow.certificate.bound import chances_of, tasks_needed
from gaitflow.certificate.certificate import Certificate, certify
from gaitflow.certificate.draw import EmptyDomain, draw_tasks
from gaitflow.certificate.judge import Verdict
from gaitflow.config.scenario import Scenario
from gaitflow.config.tasks import tasks_of
from gaitflow.core.task import Task
from gaitflow.files import atomic_write
from gaitflow.pipeline.atlas_record import atlas_record
from gaitflow.pipeline.json_file import read_json, write_json
from gaitflow.pipeline.searched import motions_of, scalars_of
from gaitflow.pipeline.workspace import Run
from gaitflow.runtime.atlas_file import atlas_bytes
from gaitflow.sampling.doubt import next_places
from gaitflow.sampling.making import MapInMaking
from gaitflow.sampling.rehearsal import rehearse
from gaitflow.sampling.rounds import Kind, Round, rounds_from, task_at
from gaitflow.store.parts import UnitStore

if TYPE_CHECKING:
    from gaitflow.execute.display import Tell

QUIET = 0.1  # of a round's picks that may be wrong for a certificate to be tried
FORGIVEN = 3  # failures after which the same certificate may be tried with more tasks
MORE_SEEDS = 1000  # apart: seeds of the parts of a sampling, so that none repeats another's numbers

Search = Callable[[Sequence[Task]], object]  # solves the units of tasks that are not stored yet


def sample(run: Run, scenario: Scenario, search: Search, tell: Tell, each: Each | None = None) -> list[Round]:
    """Choose and search tasks until the map is certified or the scenario's `most` are searched; returns all rounds.

    `each` solves several nodes of the atlas at once, see `NodeSolver`. Leaves the atlas that was judged, and what it
    was judged to be, in the run's folder. Raises EmptyDomain where no task that was searched has a motion.
    """
    sampling, space = scenario.tasks.adaptive, scenario.tasks.space
    assert sampling is not None, "a scenario whose tasks are a grid has no rounds"
    rounds = rounds_from(read_json(run.rounds), space) if run.rounds.exists() else []
    store = UnitStore(run.folder)
    making = MapInMaking(scenario, scalars_of(store, scenario), motions_of(store, scenario), tell, each)
    steps = _Steps(making, sampling.seed)
    for number in range(sampling.most):  # no sampling has as many rounds, as each searches a task at least
        if number == len(rounds):
            left = sampling.most - sum(len(one.tasks) for one in rounds)
            kind = steps.next_kind(left)
            if kind is None:
                break
            steps.begin(kind)
            rounds.append(Round(kind, tuple(steps.tasks_of(kind, left))))
            _write(run, scenario, rounds)
        else:
            steps.begin(rounds[number].kind)
        search(rounds[number].tasks)
        rounds[number] = steps.done(rounds[number])
        if not making.labelled:
            raise EmptyDomain(
                f"{scenario.name}: none of the {len(making.tasks)} tasks that were searched has a motion; give axes "
                "over which the robot can move, or more tasks to begin with (tasks.sampling.start)"
            )
        _write(run, scenario, rounds)
    tell("put together")
    atlas, judged = making.built(), making.judge_predictions()
    content = atlas_bytes(atlas)
    atomic_write(run.sampled_atlas, content)
    write_json(
        run.sampled_record,
        atlas_record(making.gaits, atlas, len(content), judged, making.growth.solver.solves, steps.missed)
        | {
            "feasible": making.domain.feasible.tolist(),
            "certificate": None if steps.certificate is None else steps.certificate.as_data(),
            "curve": steps.curve,
        },
    )
    return rounds


class _Steps:
    """What comes next, from what the rounds so far came to."""

    def __init__(self, making: MapInMaking, seed: int) -> None:
        self._making, self._seed = making, seed
        sampling = making.scenario.tasks.adaptive
        assert sampling is not None
        self._sampling = sampling
        self._quiet = False
        self._asked = 0
        self._prepared = -1  # the number of rounds after which the map was prepared for a certificate
        self._prepared_before = False  # whether it was before the last round
        self._lacking = 0
        self._rounds = self._certificates = 0
        self._drawn: list[Task] = []  # of the certificate that is being tried
        self._verdicts: list[Verdict] = []
        self.certificate: Certificate | None = None
        self.missed = 0
        self.curve: list[dict[str, Any]] = []

    def next_kind(self, left: int) -> Kind | None:
        """The kind of the next round, of at most `left` tasks; None when the sampling is over."""
        if not self._making.tasks:
            return "start"
        if self._is_good or left <= 0:
            return None
        if self._drawn and self._few_failures and 0 < self._more <= min(left, 2 * len(self._drawn)):
            return "more"
        if not self._is_ready or self._tasks_for(0) > left:
            return "doubt"
        # Tests and random picks may show where a gait is missing: one more round looks there.
        return "doubt" if self._prepare() and not self._prepared_before else "certificate"

    def begin(self, kind: Kind) -> None:
        """What a round of a kind changes in the map before its tasks are chosen."""
        self._prepared_before = self._is_ready
        if self._is_ready:
            self._prepare()
        if kind == "doubt" and self._drawn:  # the map was not good enough: the certificate's tasks help to make it
            self._making.take(self._drawn, self._verdicts)
            self._drawn, self._verdicts = [], []
        if kind == "certificate":
            self._certificates += 1

    def tasks_of(self, kind: Kind, left: int) -> list[Task]:
        """The tasks of a round of a kind that was begun, `left` at most."""
        making, grid = self._making, self._making.growth.grid
        if kind == "start":
            return list(tasks_of(making.scenario))[:left]
        if kind == "certificate":
            return self._draw(self._tasks_for(0))
        if kind == "more":
            return self._draw(self._more)
        number = min(self._sampling.further(len(grid)), left)
        low, high = (np.array([values[end] for values in grid]) for end in (0, -1))
        seed = self._seed * MORE_SEEDS + self._rounds
        atlas, picked = making.costs_atlas(), making.picked
        places = next_places(atlas, picked, making.places, making.regrets, low, high, number, seed)
        return [task_at(making.scenario.tasks.space, place) for place in places]

    def done(self, one: Round) -> Round:
        """Take in a round that was searched; returns it with what it came to."""
        making, self._rounds = self._making, self._rounds + 1
        inside = [task for task in one.tasks if making.domain.contains(task)]
        verdicts = making.judge(inside)
        if not one.of_certificate:
            making.take(one.tasks, verdicts)
            wrong = sum(verdict.dearer for verdict in verdicts)
            self._quiet = one.kind == "doubt" and wrong <= QUIET * len(one.tasks)
            self._tell_curve(one, wrong)
            return one
        self._drawn += one.tasks
        self._verdicts += verdicts
        self._asked += 1
        self.certificate = certify(self._verdicts, self._further(), self._asked, self._seed)
        self._tell_curve(one, self.certificate.dearer)
        return replace(one, certificate=self.certificate.as_data())

    @property
    def _is_ready(self) -> bool:
        """Whether the last round found the map good enough to be prepared for a certificate."""
        return self._quiet and not self._drawn

    def _prepare(self) -> int:
        """Test the map and plan random picks, once a round; at how many tasks of the last draw it lacks a gait."""
        if self._prepared != self._rounds:
            self._prepared, making = self._rounds, self._making
            making.fill()
            planned = tasks_needed(0, self._sampling.infeasible, chances_of(1)[1])
            seed = (self._seed + 1) * MORE_SEEDS**4 + self._rounds * MORE_SEEDS
            self._lacking = rehearse(making, planned, seed)
            self.missed = making.settle()
        return self._lacking

    @property
    def _is_good(self) -> bool:
        found = self.certificate
        return (
            found is not None
            and bool(self._drawn)
            and found.dearer_bound <= self._sampling.dearer
            and found.infeasible_bound <= self._sampling.infeasible
        )

    @property
    def _few_failures(self) -> bool:
        """Whether more tasks may show that the map is good enough: a pick without a motion is one too many."""
        found = self.certificate
        return found is not None and found.infeasible == 0 and self._failures <= FORGIVEN

    @property
    def _failures(self) -> int:
        return sum(verdict.dearer for verdict in self._verdicts)

    def _tasks_for(self, failures: int) -> int:
        return tasks_needed(failures, self._sampling.dearer, chances_of(self._asked + 1)[0])

    @property
    def _more(self) -> int:
        """How many tasks more would make a certificate with the failures that there are good enough."""
        return self._tasks_for(self._failures) - len(self._drawn)

    def _draw(self, number: int) -> list[Task]:
        """Fresh tasks of the domain, after those of this certificate."""
        making, seed = self._making, (self._seed + 1) * MORE_SEEDS**2 + self._certificates
        return draw_tasks(making.domain, making.scenario.tasks.space, number, seed, "sampled", skip=len(self._drawn))

    def _further(self) -> list[bool]:
        """Whether picks have a motion at further fresh tasks: as many as the bound on infeasible picks needs."""
        infeasible = sum(verdict.infeasible for verdict in self._verdicts)
        needed = tasks_needed(infeasible, self._sampling.infeasible, chances_of(self._asked)[1])
        number = max(needed - len(self._verdicts), 0)
        seed = (self._seed + 1) * MORE_SEEDS**3 + self._asked
        making = self._making
        making.tell(f"{number} further picks planned")
        return making.has_motion(draw_tasks(making.domain, making.scenario.tasks.space, number, seed, "sampled"))

    def _tell_curve(self, one: Round, wrong: int) -> None:
        making, found = self._making, self.certificate if one.of_certificate else None
        self.curve.append(
            {
                "kind": one.kind,
                "tasks": len(one.tasks),
                "searched": len(making.tasks) + len(self._drawn),
                "wrong": wrong,
                "gaits": len(making.labelled),
                "inside": float(making.domain.feasible.mean()),
                "dearer_bound": None if found is None else found.dearer_bound,
                "infeasible_bound": None if found is None else found.infeasible_bound,
            }
        )


def chosen_tasks(run: Run, scenario: Scenario) -> list[Task]:
    """All tasks that a run's rounds have chosen so far, in their order; before the first those that it begins with."""
    if not run.rounds.exists():
        return list(tasks_of(scenario))
    return [task for one in rounds_from(read_json(run.rounds), scenario.tasks.space) for task in one.tasks]


def _write(run: Run, scenario: Scenario, rounds: Sequence[Round]) -> None:
    write_json(run.rounds, [one.as_data(scenario.tasks.space) for one in rounds])
