"""Which contacts may lead from one gait to another, the most promising first: what is solved is chosen here."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.rigid_body import RigidBody
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.motion.phase_start import PhaseStart

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Way:
    """A way from the gait that is left at `first` to the one that is joined at `last`.

    contacts [phases, legs]: some of the first gait's from there on, then those of the other one that lead to `last`.
    durations [phases] s: where a solver starts.
    """

    first: PhaseStart
    last: PhaseStart
    contacts: Mask
    durations: Array

    @property
    def pattern(self) -> str:
        """The contacts as "0110/1100"."""
        return "/".join("".join("01"[int(stands)] for stands in row) for row in self.contacts.T)


def ways(
    scenario: Mapping[str, Any], firsts: Sequence[PhaseStart], lasts: Sequence[PhaseStart], task: Task
) -> list[Way]:
    """Every way at a transition's task, the most promising first: where feet stay in reach and carry the body evenly.

    Some leg always stands at some time. No leg stands all the way through, since its foothold is another one in either
    gait. A leg in the middle of a swing goes on with it.
    """
    settings = scenario["transcription"]
    phases, shortest = int(settings["phases"]), float(settings["min_phase_fraction"])
    body = RigidBody.of(scenario["robot"], task)
    found: dict[tuple[float, float, str], Way] = {}
    for first, last, contacts, durations in _joined(firsts, lasts, phases):
        landing = (contacts[0] & first.swinging) | (contacts[-1] & last.swinging)
        if contacts.all(axis=0).any() or landing.any() or not contacts.any():
            continue
        shares = shortest + (1 - phases * shortest) * durations / durations.sum()
        way = Way(first, last, contacts, task.cycle_duration * shares / shares.sum())
        found.setdefault((first.since, last.since, way.pattern), way)

    def doubt(way: Way) -> float:
        return _overreach(body, task, way) / float(body.box[0]) + _unevenness(body, way)

    return sorted(found.values(), key=doubt)


def _joined(
    firsts: Sequence[PhaseStart], lasts: Sequence[PhaseStart], phases: int
) -> Iterator[tuple[PhaseStart, PhaseStart, Mask, Array]]:
    """All beginnings of the one gait followed by endings before the other one: contacts and durations."""
    for first in firsts:
        for last in lasts:
            for kept in range(phases + 1):
                head, tail = np.arange(kept), np.arange(kept - phases, 0)
                contacts = [first.contacts.take(head, 0, mode="wrap"), last.contacts.take(tail, 0, mode="wrap")]
                durations = [first.durations.take(head, mode="wrap"), last.durations.take(tail, mode="wrap")]
                yield first, last, np.concatenate(contacts), np.concatenate(durations)


def _overreach(body: RigidBody, task: Task, way: Way) -> float:
    """How far footholds would be out of reach ahead and behind, summed over stances [m], at the commanded speed.

    A stance at an end has its foothold there; one in between has the best.
    """
    edges = np.append(0.0, np.cumsum(way.durations))
    travel = edges * (task.speed + task["acceleration"] * (edges - edges[-1]) / 2)
    reach, total = float(body.box[0]), 0.0
    at_first, at_last = (each.feet[:, 0] - each.base[0] - body.default_feet[:, 0] for each in (way.first, way.last))
    for leg, row in enumerate(way.contacts.T):
        for start, stop in stances(row):
            if start == 0:
                farthest = abs(at_first[leg] - travel[stop])
            elif stop == len(row):
                farthest = abs(at_last[leg] + travel[-1] - travel[start])
            else:
                farthest = abs(travel[stop] - travel[start]) / 2
            total += max(0.0, farthest - reach)
    return total


def stances(row: Mask) -> list[tuple[int, int]]:
    """First phase and the one after the last of each stance."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]]).astype(int)))
    return [(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]


def _unevenness(body: RigidBody, way: Way) -> float:
    """How unevenly legs at their default places would have to carry the body, each evenly within a phase.

    Their normal forces are the least whose impulses, and those about the middle of the way, lift and turn the body as
    both ends ask for. What counts is what they miss of it, what pulls, and how heave, pitch and roll are pushed.
    """
    d, total = body.dimension, float(way.durations.sum())
    phase, leg = np.nonzero(way.contacts)
    weight, g = way.durations[phase] / total, -float(body.gravity[-1])
    middle = (np.cumsum(way.durations) - way.durations / 2)[phase] / total
    places = body.default_feet[leg, : d - 1].T / np.abs(body.default_feet).max()
    levers = np.concatenate([np.ones((1, len(leg))), places])
    up = [each.base[d + body.angles + d - 1] for each in (way.first, way.last)]
    risen = way.last.base[d - 1] - way.first.base[d - 1]
    rows = np.concatenate([levers * weight, levers * weight * 2 * (1 - middle)])
    wanted = np.zeros(2 * d)
    wanted[0] = 1 + (up[1] - up[0]) / (g * total)
    wanted[d] = 1 + 2 * (risen - up[0] * total) / (g * total**2)
    normal = np.linalg.lstsq(rows / np.sqrt(weight), wanted, rcond=1e-9)[0] / np.sqrt(weight)
    missed = float(np.abs(rows @ normal - wanted).sum())
    pulling = max(0.0, -float(normal.min(initial=0.0)))
    pushes = np.array([levers[:, phase == i] @ normal[phase == i] for i in range(len(way.durations))])
    pushes[:, 0] -= 1
    return 10 * missed + 3 * pulling + float((way.durations / total) @ (pushes**2).sum(axis=1))
