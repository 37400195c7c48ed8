"""The gait map as a planner uses it: ask which gait a task takes, and have it refined into a motion."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from gaitflow.core.errors import OutOfDomain
from gaitflow.core.legacy import modern_name
from gaitflow.core.trajectory import Array
from gaitflow.motion import Journey, Motion
from gaitflow.motion.arguments import checked_time
from gaitflow.motion.journey import last_of
from gaitflow.runtime.artifact import Artifact, load_artifact
from gaitflow.runtime.attempt import Candidate
from gaitflow.runtime.choice import Choice, Choices
from gaitflow.runtime.hysteresis import MARGIN, checked_margin, is_kept
from gaitflow.runtime.left_out import Chooser, ChosenValue, Per, left_out
from gaitflow.runtime.manifest import Gait, Manifest
from gaitflow.runtime.plan import TOP, Asked, Plan, refine_ranked
from gaitflow.runtime.questions import Questions
from gaitflow.runtime.remote import local_folder
from gaitflow.runtime.switching import check_switchable
from gaitflow.runtime.tensors import WarmStart, warm_start
from gaitflow.runtime.thread_solvers import ThreadSolvers
from gaitflow.runtime.versions import resolve

FARTHEST = 1e6  # in an axis' unit: of a task beyond the domain, what the classifier's float32 can take


class GaitMap:
    """A published map from tasks to gaits. Build it with `GaitMap.load`.

    A task is given by its values on the map's axes (`axes`): speed [m/s] and cycle_duration [s], by position or by
    name, and the others by name. An axis that the map holds at one value may be given with that value. One axis of the
    command, mostly the cycle duration, may be left to the map.

    Immutable and safe to use from many threads, each of which gets a solver of its own.
    """

    def __init__(self, artifact: Artifact, trust_code: bool = False, compiled: Path | None = None) -> None:
        self._artifact = artifact
        manifest = artifact.manifest
        self._names = tuple(gait.name for gait in manifest.gaits)
        self._questions = Questions(manifest.space)
        self._solvers = ThreadSolvers(artifact, trust_code, compiled)

    @classmethod
    def load(
        cls, path: str | PathLike[str], trust_code: bool = False, compiled: str | PathLike[str] | None = None
    ) -> GaitMap:
        """Load `models/<scenario>/<version>`, or the newest version in `models/<scenario>`, here or at an address.

        The digest of every file that is read is checked. Maps of formats 1 and 2 hold their problem as code. They plan
        only with `trust_code`, which lets that code run in this process.

        `compiled` is the folder where an export of this map was built (docs/runtime.md). Plans are the same then, and
        three to six times as fast. The library in that folder runs in this process: take one that you built yourself.

        Raises ArtifactError, which names the file and what is wrong with it.
        """
        folder = None if compiled is None else Path(compiled)
        return cls(load_artifact(resolve(local_folder(path))), trust_code, folder)

    @property
    def manifest(self) -> Manifest:
        """What the map says of itself: scenario, version, domain, metrics."""
        return self._artifact.manifest

    @property
    def axes(self) -> tuple[str, ...]:
        """The axes that the map ranges over."""
        return self.manifest.space.ranged

    @property
    def gaits(self) -> tuple[Gait, ...]:
        """The gaits that the map chooses from, in the order of `Choices.index`."""
        return self.manifest.gaits

    def select(
        self,
        speed: float | None = None,
        cycle_duration: float | None = None,
        *,
        per: Per = "second",
        beyond: bool = False,
        previous: Choice | None = None,
        margin: float = MARGIN,
        **axes: float,
    ) -> Choice:
        """The gait for one task: the one that the atlas predicts to cost least, which `plan` tries first.

        Over more than three axes it is the gait whose cost over its probability, the classifier's, is least. Where the
        atlas knows no gait, it is the classifier's likeliest. Outside the map's domain there is no gait, unless
        `beyond` asks for a guess.

        The gait of the `previous` choice is kept as long as it is predicted to cost at most `margin` (relative) more
        than the cheapest one, at this task or at one a tenth of a step of the map's grid away.

        One axis of the command may be left out, mostly the cycle duration. It takes the value in the domain of least
        predicted cost `per` "second" or "metre", which `chosen` reports. The value of the previous choice is kept
        within the margin as well.

        Raises ValueError for an argument that is no finite number, for an axis that the map does not have or that is
        missing, and for a previous gait that it does not have; OutOfDomain where there is no value to choose.
        """
        keep, margin = self._kept(previous), checked_margin(margin)
        task, chosen = self._task(speed, cycle_duration, axes, per)
        if chosen is not None and keep is not None and previous is not None:
            task, chosen = self._kept_value(task, chosen, per, previous, margin)
        domain = self.manifest.domain
        inside = domain.contains(task)
        if not inside and not (beyond and self._questions.physical(task)):
            return Choice(task, False, None, None, 0.0, (), self._warm_start, self._distance)
        place = self._place(task)
        probabilities = self._probabilities(place)
        candidates = self._candidates(place, probabilities)
        if keep not in (None, candidates[0].gait) and self._is_kept(place, keep, margin):
            candidates.sort(key=lambda each: each.gait != keep)
        first = candidates[0]
        gaits = dict.fromkeys(each.gait for each in candidates)
        ranked = tuple([(self._names[each], probabilities[each]) for each in gaits])
        gait, probability = ranked[0]
        pattern = self._artifact.pattern(first.gait, first.sheet)
        return Choice(task, inside, gait, pattern, probability, ranked, self._warm_start, self._distance, chosen)

    def select_many(
        self, speed: ArrayLike | None = None, cycle_duration: ArrayLike | None = None, **axes: ArrayLike
    ) -> Choices:
        """`select` for arrays of tasks that broadcast against each other.

        Raises ValueError as `select` does, and for shapes that do not broadcast.
        """
        tasks = self._questions.many(speed, cycle_duration, axes)
        inside = self.manifest.domain.contains_many(tasks)
        places = np.stack([tasks[axis][inside] for axis in self.axes], axis=-1)
        index = np.full(inside.shape, -1, dtype=np.intp)
        probability = np.zeros(inside.shape)
        if len(places):
            rows = self._artifact.classifier(places.astype(np.float32)).astype(np.float64)
            chosen = [self._candidates(place, row)[0].gait for place, row in zip(places, rows.tolist(), strict=True)]
            index[inside] = chosen
            probability[inside] = rows[np.arange(len(rows)), chosen]
        gaits = np.empty(inside.shape, dtype=object)
        gaits[...] = np.array([*self._names, None], dtype=object)[index]
        return Choices(gaits, index, probability, inside)

    def plan(
        self,
        speed: float | None = None,
        cycle_duration: float | None = None,
        *,
        gait: str | None = None,
        per: Per = "second",
        top: int = TOP,
        beyond: bool = False,
        **axes: float,
    ) -> Plan:
        """A motion for one task, refined from a predicted start; needs gaitflow[solve].

        The gait that `select` names is tried first. Gaits that the atlas does not know at this task come last, by their
        probability. If none of a gait's patterns that the atlas knows here leads to a feasible motion, the next gait
        is tried, `top` gaits at most. Others that may cost less than what was found are tried as well, and all that are
        likely the best; over more than two axes none that hardly is. `Plan.path` and `Plan.tried` say so. With `gait`
        only that gait is tried. An axis that is left out is chosen as `select` does, for that gait. `beyond` plans
        outside the map's domain as well; the motion is checked all the same, and `Plan.feasible` has the verdict.

        Raises OutOfDomain outside the domain without `beyond`, and for a task that is not physical; ValueError as
        `select`, and for a gait that the map does not have; ImportError without CasADi; ArtifactError when the map's
        problem cannot be rebuilt.
        """
        started = time.perf_counter()
        if isinstance(top, bool) or not isinstance(top, int) or top < 1:
            raise ValueError(f"top = {top!r}: must be a number of gaits to try, 1 or more")
        forced, domain = None if gait is None else self._index(gait), self.manifest.domain
        values, chosen = self._task(speed, cycle_duration, axes, per, forced)
        inside = domain.contains(values)
        if not inside and not (beyond and self._questions.physical(values)):
            raise OutOfDomain(domain.explain(values))
        refiner = self._solvers.fastest()
        place = self._place(values)
        probabilities = self._probabilities(place)
        candidates = self._candidates(place, probabilities)
        ranked = [
            (each, self.manifest.gaits[each.gait], probabilities[each.gait])
            for each in candidates
            if forced in (None, each.gait)
        ]
        task = self.manifest.space.task({axis: values[axis] for axis in self.axes})
        plan = refine_ranked(refiner, ranked, Asked(task, values, inside, domain.distance(values), started), top)
        return replace(plan, scenario=self.manifest.scenario, chosen=chosen)

    def switch(self, motion: Motion | Journey, other: Motion, after: float = 0.0) -> Journey:
        """The journey that leaves a motion at the start of one of its phases, from `after` [s] on, for another motion.

        Several transitions are solved, which differ in where the one motion is left and the other one joined, in their
        contacts and in their duration. The cheapest one found, by this map's objective, is taken; see `Journey`. A
        journey is left once it has settled. Needs gaitflow[solve].

        Raises ValueError for a time that is no finite number, for motions of another robot than the map's, and for
        motions that no transition can join; NoTransition when none is found; ImportError without CasADi.
        """
        asked = checked_time(after, "after")
        left = last_of(motion)
        check_switchable(self.manifest.scenario, left.motion, other)
        plan = self._solvers.transition_planner().plan(left.motion, other)
        if isinstance(motion, Journey):
            asked = max(asked, motion.settled)
        return Journey.of(motion, plan, left.next_time(plan.first.since, asked), other)

    def mean_start(self, gait: str, cycle_duration: float) -> WarmStart:
        """The paper's warm start of a gait: the mean over its region, scaled to the cycle duration [s].

        Raises ValueError for a gait that the map does not have.
        """
        index, manifest = self._index(gait), self.manifest
        vectors, task = self._artifact.tensors.mean(index), {"cycle_duration": cycle_duration}
        return warm_start(manifest.layout, gait, manifest.gaits[index].pattern, vectors, task)

    def _index(self, gait: str) -> int:
        """The number of a gait, by its name of today or an earlier one. Raises ValueError with those the map has."""
        name = modern_name(gait) if isinstance(gait, str) else gait
        if name not in self._names:
            raise ValueError(f"gait = {gait!r}: the map has {', '.join(self._names)}")
        return self._names.index(name)

    def _task(
        self,
        speed: float | None,
        cycle_duration: float | None,
        axes: Mapping[str, float],
        per: Per,
        gait: int | None = None,
    ) -> tuple[dict[str, float], ChosenValue | None]:
        """The values that are asked for, with the one chosen that is left out, for a gait or the best one."""
        if per not in ("second", "metre"):
            raise ValueError(f"per = {per!r}: must be 'second' or 'metre'")
        given = self._questions.given(speed, cycle_duration, axes)
        axis = left_out(self.axes, given)
        if axis is None:
            return self._questions.one(given), None
        values = self._questions.one(given | {axis: self.manifest.domain.axes[axis][0]})
        chosen = self._chooser(axis, per).cheapest(values, gait)
        if chosen is None:
            others = ", ".join(f"{other} = {values[other]:g}" for other in self.axes if other != axis)
            raise OutOfDomain(f"{others}: the map knows no cost at any {axis} there; give one as well")
        return values | {axis: chosen.value}, chosen

    def _kept_value(
        self, task: dict[str, float], chosen: ChosenValue, per: Per, previous: Choice, margin: float
    ) -> tuple[dict[str, float], ChosenValue]:
        """The value chosen before, or else the best one of the gait before, within the margin of the best of all."""
        chooser, gait, before = self._chooser(chosen.axis, per), self._index(str(previous.gait)), previous.chosen
        kept = chooser.same(task, gait, before.value) if before is not None and before.axis == chosen.axis else None
        for own in (kept, chooser.cheapest(task, gait)):
            if own is not None and own.rate(per) <= (1 + margin) * chosen.rate(per):
                return task | {own.axis: own.value}, own
        return task, chosen

    def _chooser(self, axis: str, per: Per) -> Chooser:
        return Chooser(self._artifact.atlas, self.manifest.domain, self.manifest.cost_scale, axis, per)

    def _kept(self, previous: object) -> int | None:
        """The number of a previous choice's gait, None where it had none."""
        if previous is None:
            return None
        if not isinstance(previous, Choice):
            raise ValueError(f"previous = {previous!r}: must be a choice, what `select` gave before")
        return None if previous.gait is None else self._index(previous.gait)

    def _is_kept(self, place: Array, gait: int, margin: float) -> bool:
        steps = self.manifest.domain.steps
        return is_kept(self._artifact.atlas, self._probabilities, steps, place, gait, margin)

    def _place(self, task: Mapping[str, float]) -> Array:
        return np.array([task[axis] for axis in self.axes])

    def _probabilities(self, place: Array) -> list[float]:
        far = np.clip(place, -FARTHEST, FARTHEST).astype(np.float32)
        row: list[float] = self._artifact.classifier(far[None, :])[0].tolist()
        return row

    def _candidates(self, place: Array, probabilities: list[float]) -> list[Candidate]:
        """Every gait, with each of its patterns that the atlas knows here, in the order of choosing and trying.

        First what the atlas knows, by `Atlas.by_cost`; then the other gaits by probability.
        """
        atlas = self._artifact.atlas
        known = [Candidate(atlas.sheets[sheet].gait, sheet) for sheet in atlas.by_cost(place, probabilities)]
        gaits = {each.gait for each in known}
        likeliest = sorted(range(len(probabilities)), key=probabilities.__getitem__, reverse=True)
        return known + [Candidate(gait, None) for gait in likeliest if gait not in gaits]

    def _warm_start(self, gait: str, task: Mapping[str, float]) -> WarmStart:
        index, atlas, place = self._names.index(gait), self._artifact.atlas, self._place(task)
        ranked = atlas.ranked(place, self._probabilities(place) if atlas.is_wide else None)
        own = [sheet for sheet in ranked if atlas.sheets[sheet].gait == index]
        predicted = atlas.predict(own[0], place) if own else None
        if predicted is None:
            return self.mean_start(gait, task["cycle_duration"])
        sheet = atlas.sheets[own[0]]
        vectors = sheet.space.join(sheet.space.decode(predicted.point), predicted.cost)
        return warm_start(self.manifest.layout, gait, sheet.pattern, vectors, task)

    def _distance(self, task: Mapping[str, float]) -> float:
        return self.manifest.domain.distance(task)
