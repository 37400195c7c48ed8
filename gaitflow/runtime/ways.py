"""Which contacts may lead from one gait to another, in the order in which they are solved: most promising first."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from gaitflow.core.layout import Layout
from gaitflow.core.rigid_body import RigidBody
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.motion.phase_start import PhaseStart
from gaitflow.runtime.way import Mask, Way, end_states, interpolated


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
    layout = Layout.of(scenario)

    def doubt(way: Way) -> float:
        start = interpolated(scenario, way, *end_states(way, task), layout.times(way.durations))
        return _overreach(body, way, start) / float(body.box[0]) + _unevenness(body, way, start)

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


def _overreach(body: RigidBody, way: Way, start: Trajectory) -> float:
    """How far feet that stand are out of reach at the worst [m], summed over the legs."""
    steps = (len(start.times) - 1) // len(way.durations)
    position, angles, _, _ = body.split(start.base)
    outside = body.box_excess(position, angles, start.feet)[..., 0]
    stands = np.repeat(way.contacts, steps, axis=0)
    worst = np.maximum(outside[:-1], outside[1:]) * stands
    return float(np.maximum(worst, 0.0).max(axis=0).sum())


def _unevenness(body: RigidBody, way: Way, start: Trajectory) -> float:
    """How unevenly the legs would have to carry the body, each evenly within a phase.

    Their normal forces are the least whose impulses, and those about the middle of the way, lift and turn the body as
    both ends ask for. What counts is what they miss of it, what pulls, and how heave, pitch and roll are pushed.
    """
    d, total = body.dimension, float(way.durations.sum())
    steps = (len(start.times) - 1) // len(way.durations)
    halves = np.arange(len(way.durations)) * steps + steps // 2
    phase, leg = np.nonzero(way.contacts)
    weight, g = way.durations[phase] / total, -float(body.gravity[-1])
    middle = (np.cumsum(way.durations) - way.durations / 2)[phase] / total
    offsets = start.feet[halves] - start.base[halves, None, :d]
    places = offsets[phase, leg, :-1].T / np.abs(body.default_feet).max()
    levers = np.concatenate([np.ones((1, len(leg))), places])
    up = start.base[[0, -1], d + body.angles + d - 1]
    risen = start.base[-1, d - 1] - start.base[0, d - 1]
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
