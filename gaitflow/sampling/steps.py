"""What an adaptive sampling does next: the kind of the next round, its tasks, and what a searched round came to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from gaitflow.certificate.bound import chances_of, has_hope, tasks_needed, tasks_of_look
from gaitflow.certificate.certificate import Certificate, certify
from gaitflow.certificate.draw import draw_tasks
from gaitflow.certificate.judge import Verdict
from gaitflow.config.tasks import tasks_of
from gaitflow.core.task import Task
from gaitflow.sampling.doubt import next_places
from gaitflow.sampling.making import MapInMaking
from gaitflow.sampling.picks import Picks, Suspect
from gaitflow.sampling.planning import Planning
from gaitflow.sampling.rehearsal import rehearse, where_missing
from gaitflow.sampling.rounds import Kind, Round, task_at

QUIET = 0.1  # of a round's picks that may be wrong for a certificate to be tried
# Or the searches since the last certificate, over those that one takes. Doubt looks where picks are most likely to be
# wrong, so with small rounds it may find one in each, for a map with two wrong of 358 random picks.
ENOUGH = 0.5
SPARE = 2  # tasks without a plan that a certificate allows for: planning takes a hundredth of a search
MORE_SEEDS = 1000  # apart: seeds of the parts of a sampling, so that none repeats another's numbers


class Steps:
    """What comes next, from what the rounds so far came to.

    `planning_of` is how the map in the making plans; `learning` the digest of what trains the classifier that its plans
    ask.
    """

    def __init__(
        self,
        making: MapInMaking,
        seed: int,
        planning_of: Callable[[MapInMaking], Planning],
        learning: str,
    ) -> None:
        self._making, self._picks, self._seed, self._learning = making, Picks(making), seed, learning
        self._planning_of = planning_of
        self._planning: Planning | None = None  # of the map whose certificate is tried
        sampling = making.scenario.tasks.adaptive
        assert sampling is not None
        self._sampling = sampling
        self._quiet = False
        self._since = 0  # searches since the start, or since the last certificate
        self._asked = 0
        self._prepared = -1  # the number of rounds after which the map was prepared for a certificate
        self._prepared_before = False  # whether it was before the last round
        self._lacking: list[Suspect] = []  # random tasks at which the map lacked a gait when it was prepared
        self._rounds = self._certificates = 0
        self._known = 0  # tasks of the dataset that the sampling began from
        self._drawn: list[Task] = []  # of the certificate that is being tried, all inside the domain
        self._look = 0  # at it, the next one
        self._verdicts: list[Verdict] = []  # of its picks, and of its plans, as far as they were judged
        self._plans: list[Verdict] = []
        self._have_plans: list[bool] = []  # at the certificate's further tasks
        self.certificate: Certificate | None = None  # of the map as it is
        self.missed = 0
        self.curve: list[dict[str, Any]] = []

    def next_kind(self, left: int) -> Kind | None:
        """The kind of the next round, of at most `left` tasks; None when the sampling is over."""
        if left <= 0 or (self._is_good and not self._is_outdated):
            return None
        if self._start:
            return "start"
        if (self._has_hope or self._is_outdated) and self._tasks_of_next_look - len(self._drawn) <= left:
            return "more"
        if self._drawn and self._tasks_to_ask_anew > left:
            return None  # of a map that learned more there would be no certificate
        if not self._is_ready or self._tasks_of_next_look > left:
            return "doubt"
        # Tests and random picks may show where a gait is missing: one more round looks there.
        return "doubt" if self._prepare() and not self._prepared_before else "certificate"

    def begin(self, kind: Kind) -> None:
        """What a round of a kind changes in the map before its tasks are chosen."""
        self._prepared_before = self._is_ready
        if self._is_ready:
            self._prepare()
        if kind == "doubt" and self._drawn:  # the map was not good enough: the certificate's tasks help to make it
            self._making.take(self._drawn, self._judged())
            self._drawn, self._verdicts, self._plans, self._since, self._look = [], [], [], 0, 0
            self._planning, self._have_plans = None, []
            self.certificate = None  # it is of the map before
        if kind == "certificate":
            self._certificates += 1

    def tasks_of(self, kind: Kind, left: int) -> list[Task]:
        """The tasks of a round of a kind that was begun, `left` at most."""
        if kind == "start":
            return self._start[:left]
        if kind in ("certificate", "more"):
            return self._draw(self._tasks_of_next_look - len(self._drawn))
        making, grid = self._making, self._making.growth.grid
        number = min(self._sampling.further(len(grid)), left)
        low, high = (np.array([values[end] for values in grid]) for end in (0, -1))
        seed = self._seed * MORE_SEEDS + self._rounds
        atlas, picked = making.costs_atlas(), making.picked
        # In doubt the few per cent that a missing gait promises weigh less than what unsure predictions may be off by.
        missing = where_missing(self._lacking)[:number]
        ranged, space = making.scenario.tasks.ranges, making.scenario.tasks.space
        known = np.vstack([making.places, *(np.array(task.on(ranged)) for task, _ in missing)])
        regrets = np.append(making.regrets, [saving for _, saving in missing])
        places = next_places(atlas, picked, known, regrets, low, high, number - len(missing), seed)
        return [*(task for task, _ in missing), *(task_at(space, place) for place in places)]

    def done(self, one: Round) -> Round:
        """Take in a round that was searched; returns it with what it came to."""
        making, self._rounds, self._lacking = self._making, self._rounds + 1, []
        if one.kind == "known":
            self._known += len(one.tasks)
            self._asked += one.askings
        if one.kind in ("known", "doubt"):
            self._since += len(set(one.tasks) - set(tasks_of(making.scenario)))
        if not one.of_certificate:
            verdicts = self._picks.judge([task for task in one.tasks if making.domain.contains(task)])
            making.take(one.tasks, verdicts)
            wrong = sum(verdict.dearer for verdict in verdicts)
            self._quiet = one.kind == "doubt" and wrong <= QUIET * len(one.tasks)
            self._tell_curve(one, wrong)
            making.tell(f"{one.kind}: {wrong} of {len(one.tasks)} picks were wrong, {len(making.labelled)} gaits")
            return one
        self._drawn += one.tasks
        self._asked, before = self._asked + 1, self.certificate
        if one.certificate is None:
            self._planning = planning = self._planning or self._planning_of(making)
            self._plans += self._picks.judge_plans(self._drawn[len(self._plans) :], planning)
            # Over few axes `select` names what costs least, which was judged for the rounds to come, too.
            selected = self._picks.judge(self._drawn, planning) if making.growth.is_wide else self._judged()
            have_plans = self._further(planning)
            self.certificate = certify(self._plans, selected, have_plans, self._asked, self._seed, self._learning)
        else:  # of a sampling that was stopped: what an asking came to stays, and is not planned again
            self.certificate = one.certificate
        if before is None or before.learning == self.certificate.learning:
            self._look += 1
        self._tell_curve(one, self.certificate.dearer)
        return replace(one, certificate=self.certificate)

    @property
    def _start(self) -> list[Task]:
        """The tasks of the start that are not searched yet."""
        searched = set(self._making.tasks)
        return [task for task in tasks_of(self._making.scenario) if task not in searched]

    @property
    def _is_ready(self) -> bool:
        """Whether the last round found the map good enough to be prepared for a certificate; not before the start."""
        enough = self._since >= ENOUGH * self._tasks_of_next_look
        return (self._quiet or enough) and not self._drawn and not self._start

    def _prepare(self) -> bool:
        """Test the map and plan random picks, once a round; whether it lacked a gait at one of the last draw."""
        if self._prepared != self._rounds:
            self._prepared, making = self._rounds, self._making
            making.fill()
            if not making.growth.is_wide:  # over so many axes a node at a random task tells of too few others
                planned = tasks_needed(0, self._sampling.infeasible, chances_of(1)[1])
                seed = (self._seed + 1) * MORE_SEEDS**4 + self._rounds * MORE_SEEDS
                self._lacking = rehearse(making, self._picks, planned, seed)
            self.missed = making.settle()
        return bool(self._lacking)

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
    def _is_outdated(self) -> bool:
        """Whether the certificate was asked of plans by a classifier that would be trained otherwise now.

        Its tasks had no part in making the map. So the look is repeated, as another asking.
        """
        return self.certificate is not None and bool(self._drawn) and self.certificate.learning != self._learning

    @property
    def _tasks_of_next_look(self) -> int:
        """How many tasks a certificate has at its next look, those of the looks before among them."""
        return tasks_of_look(self._look - self._is_outdated, self._sampling.dearer, self._asked + 1)

    @property
    def _tasks_to_ask_anew(self) -> int:
        """How many tasks a round of doubt and another certificate take."""
        further = self._sampling.further(len(self._making.growth.grid))
        return further + tasks_of_look(0, self._sampling.dearer, self._asked + 1)

    @property
    def _has_hope(self) -> bool:
        """Whether more tasks may show that the map is good enough."""
        found, allowed = self.certificate, self._sampling
        if found is None or not self._drawn or found.infeasible_bound > allowed.infeasible:
            return False
        return has_hope(found.dearer, len(self._drawn), self._look - 1, allowed.dearer)

    def _draw(self, number: int) -> list[Task]:
        """Fresh tasks of the domain, after those of this certificate."""
        # Earlier samplings had fewer certificates than the tasks that are known of them: none is drawn again.
        making, seed = self._making, (self._seed + 1) * MORE_SEEDS**2 + self._known + self._certificates
        return draw_tasks(making.domain, making.scenario.tasks.space, number, seed, "sampled", skip=len(self._drawn))

    def _judged(self) -> list[Verdict]:
        """Verdicts of the picks at all tasks of this certificate."""
        self._verdicts += self._picks.judge(self._drawn[len(self._verdicts) :])
        return self._verdicts

    def _further(self, planning: Planning) -> list[bool]:
        """Whether there are plans at further fresh tasks: as many as the bound on tasks without one needs."""
        needed = tasks_needed(SPARE, self._sampling.infeasible, chances_of(self._asked)[1])
        making, known = self._making, len(self._have_plans)
        number = max(needed - len(self._plans) - known, 0)
        seed = (self._seed + 1) * MORE_SEEDS**3 + self._known + self._certificates
        making.tell(f"{number} further tasks planned")
        tasks = draw_tasks(making.domain, making.scenario.tasks.space, number, seed, "sampled", skip=known)
        self._have_plans += [plan is not None for plan in planning.plans(tasks)]
        return self._have_plans

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
