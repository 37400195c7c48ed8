"""The stage `solve` of a scenario that chooses its own tasks: rounds of searches until the map's certificate is good.

What was chosen is written down before it is searched, and a round's searches are units of the run's store. So an
interrupted sampling repeats its rounds from the store, without a search, and goes on in the one that it was in.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from gaitflow.atlas.node import Each
from gaitflow.certificate.draw import EmptyDomain
from gaitflow.config.scenario import Scenario
from gaitflow.config.tasks import tasks_of
from gaitflow.core.task import Task
from gaitflow.files import atomic_write
from gaitflow.pipeline.atlas_record import atlas_record
from gaitflow.pipeline.chances import learning_of, planning_of
from gaitflow.pipeline.earlier_map import earlier_atlas
from gaitflow.pipeline.json_file import read_json, write_json
from gaitflow.pipeline.searched import motions_of, scalars_of
from gaitflow.pipeline.workspace import Run
from gaitflow.runtime.atlas_file import atlas_bytes
from gaitflow.sampling.making import MapInMaking
from gaitflow.sampling.rounds import Round, rounds_from
from gaitflow.sampling.steps import Steps
from gaitflow.store.parts import UnitStore

if TYPE_CHECKING:
    from gaitflow.execute.display import Tell

Search = Callable[[Sequence[Task]], object]  # solves the units of tasks that are not stored yet


def sample(
    run: Run,
    scenario: Scenario,
    search: Search,
    tell: Tell,
    each: Each | None = None,
    begun: Sequence[Round] = (),
) -> list[Round]:
    """Choose and search tasks until the map is certified or the scenario's `most` are searched; returns all rounds.

    `each` solves several nodes of the atlas at once, see `NodeSolver`. `begun` are the first rounds, of a dataset whose
    searches the run's store has. Leaves the atlas that was judged, and what it was judged to be, in the run's folder.
    Raises EmptyDomain where no task that was searched has a motion, ValueError where the sampling has begun with other
    tasks.
    """
    sampling = scenario.tasks.adaptive
    assert sampling is not None, "a scenario whose tasks are a grid has no rounds"
    rounds = written_rounds(run, scenario)
    if begun and not rounds:
        rounds = list(begun)
        _write(run, scenario, rounds)
    elif [_chosen(one) for one in rounds[: len(begun)]] != [_chosen(one) for one in begun]:
        raise ValueError(
            f"{scenario.name}: its sampling has begun already, and not from this dataset; leave --begin away to go on "
            f"with it, or remove {run.rounds} to begin again"
        )
    store = UnitStore(run.folder)
    making = MapInMaking(scenario, scalars_of(store, scenario), motions_of(store, scenario), tell, each)
    if (earlier := earlier_atlas(run, scenario, making.problem)) is not None:
        making.begin_with(earlier)
    steps = Steps(making, sampling.seed, planning_of, learning_of(scenario))
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
    atlas = making.built()
    tell("its predictions judged")
    judged = making.judge_predictions(atlas)
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


def chosen_tasks(run: Run, scenario: Scenario) -> list[Task]:
    """All tasks that a run's rounds have chosen so far, in their order; before the first those that it begins with."""
    rounds = written_rounds(run, scenario)
    return [task for one in rounds for task in one.tasks] if rounds else list(tasks_of(scenario))


def written_rounds(run: Run, scenario: Scenario) -> list[Round]:
    """The rounds of a run so far, none before there is one."""
    return rounds_from(read_json(run.rounds), scenario.tasks.space) if run.rounds.exists() else []


def _chosen(one: Round) -> Round:
    """A round without what its certificate came to."""
    return replace(one, certificate=None)


def _write(run: Run, scenario: Scenario, rounds: Sequence[Round]) -> None:
    write_json(run.rounds, [one.as_data(scenario.tasks.space) for one in rounds])
