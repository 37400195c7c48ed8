"""The stages of a map, each from files to files: solve -> label -> atlas -> train -> publish -> report.

Pure functions of the packages below do the work; here they get their files, and only here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gaitflow.config.scenario import Scenario, digest_of
from gaitflow.files import atomic_write, make_folder
from gaitflow.pipeline.earlier import atlas_of, domain_of, need
from gaitflow.pipeline.json_file import read_json, write_json
from gaitflow.pipeline.stamps import stamp
from gaitflow.pipeline.workspace import Workspace

if TYPE_CHECKING:
    import pandas as pd

    from gaitflow.config.cluster import Profile
    from gaitflow.core.task import Task
    from gaitflow.execute.count import RunState

GUIDED_REMARK = (
    "the search was guided: a pick counts as infeasible where it was not solved at that task, be it for want of a "
    "motion or because a probe was too dear to go on with; regret is over the other picks"
)


@dataclass(frozen=True)
class PublishedRun:
    """Where a run was published, and what of its judgement the user should know."""

    version: str
    dataset: Path
    model: Path
    remarks: tuple[str, ...] = ()


def solve(
    workspace: Workspace,
    scenario: Scenario,
    workers: int,
    profile: Profile | None = None,
    begin: Path | None = None,
    earlier: Path | None = None,
) -> tuple[RunState, Path]:
    """Solve every unit that the store lacks and collect them into one file; choose the tasks first, where it says so.

    On `workers` processes of this machine, or with a profile on the jobs of a cluster. `begin` is a dataset from whose
    searches the sampling begins, `earlier` a map made from it, whose nodes are solved again instead of grown. Raises
    DriverAlive when another process or job solves the run, WriteError, ValueError when the dataset is not sound or of
    other searches, or the map of another problem, ConfigError where a sampling's classifier cannot be trained.
    """
    from gaitflow.dataset.collect import collect
    from gaitflow.execute.display import display
    from gaitflow.pipeline.drive import drive
    from gaitflow.store.parts import UnitStore
    from gaitflow.store.units import plan_units

    run = workspace.run(scenario)
    make_folder(run.folder)
    stamp(run, scenario, "problem")
    store = UnitStore(run.folder)
    with display(scenario.name) as tell:

        def search(tasks: Sequence[Task] | None = None) -> RunState:
            return drive(plan_units(scenario, tasks), store, tell, workers, profile)

        if scenario.tasks.adaptive is None:
            if begin is not None:
                raise ValueError(f"{scenario.name}: its tasks are a grid; only a sampling begins from a dataset")
            return search(), collect(store, scenario)
        from gaitflow.execute.node_processes import node_processes
        from gaitflow.learn.installed import check_installed
        from gaitflow.pipeline.earlier_map import keep_earlier
        from gaitflow.pipeline.kept_nodes import kept_nodes
        from gaitflow.pipeline.sampling import sample
        from gaitflow.pipeline.searches import begin_from
        from gaitflow.sampling.rounds import askings, held_out

        check_installed(scenario.learning)  # a sampling trains classifiers for its plans
        begun = () if begin is None else begin_from(store, scenario, begin)
        if begin is not None and earlier is not None:
            keep_earlier(run, scenario, earlier, begin)
        with (
            node_processes(scenario, workers) as solving,
            kept_nodes(run.solved_nodes, scenario, solving) as each,
        ):
            rounds = sample(run, scenario, search, tell, each, begun)
        chosen = [task for one in rounds for task in one.tasks]
        return search(chosen), collect(store, scenario, chosen, held_out(rounds), askings=askings(rounds))


def label(workspace: Workspace, scenario: Scenario) -> pd.DataFrame:
    """Label every task with its cheapest gait; writes the labels and the gaits' costs."""
    from gaitflow.pipeline.labelling import write_labels

    run = workspace.run(scenario)
    need(run.solutions, f"gaitflow solve {scenario.name}")
    stamp(run, scenario, "ties")
    return write_labels(run, scenario)


def atlas(workspace: Workspace, scenario: Scenario, workers: int = 1) -> dict[str, Any]:
    """Grow the solutions of every labelled gait into an atlas; writes it and how good its predictions are.

    `workers` processes solve its nodes. A map that chose its tasks has its atlas since `solve`.
    """
    import pandas as pd

    from gaitflow.dataset import load_solutions
    from gaitflow.pipeline.growing import grown

    run = workspace.run(scenario)
    need(run.labels, f"gaitflow label {scenario.name}")
    labels, costs = pd.read_parquet(run.labels), pd.read_parquet(run.gait_costs)
    data: dict[str, Any]
    if scenario.tasks.adaptive is not None:
        content, data = run.sampled_atlas.read_bytes(), read_json(run.sampled_record)
        of_key = dict(costs[["gait_key", "gait"]].itertuples(index=False, name=None))
        data["gaits"] = [of_key[key] for key in data["gaits"]]
    else:
        domain = domain_of(run, scenario, labels)
        content, data = grown(scenario, labels, costs, load_solutions(run.solutions), domain, workers)
    atomic_write(run.atlas, content)
    write_json(run.atlas_record, data)
    return data


def train(workspace: Workspace, scenario: Scenario, constant: bool) -> dict[str, Any]:
    """Train and judge the classifiers; writes the winner and how all of them did."""
    import pandas as pd

    from gaitflow.execute.display import display
    from gaitflow.learn.installed import check_installed
    from gaitflow.learn.mirror import images_of_gaits
    from gaitflow.learn.train import KnownCosts
    from gaitflow.learn.train import train as train_all

    check_installed(scenario.learning)
    run = workspace.run(scenario)
    need(run.labels, f"gaitflow label {scenario.name}")
    need(run.atlas_record, f"gaitflow atlas {scenario.name}")
    stamp(run, scenario, "learning")
    labels, costs = pd.read_parquet(run.labels), pd.read_parquet(run.gait_costs)
    known, gaits = atlas_of(run, scenario)
    costs_known = KnownCosts(known, tuple(gaits), domain_of(run, scenario, labels))
    axes, image_of = scenario.tasks.space.ranged, images_of_gaits(scenario, costs)
    with display(f"{scenario.name}: train") as tell:
        training = train_all(labels, costs, axes, scenario.learning, constant, costs_known, image_of, tell)
    data = training.as_data()
    if scenario.strategy.name == "guided":
        data["remarks"] = [*data["remarks"], GUIDED_REMARK]
    atomic_write(run.classifier, training.onnx)
    write_json(run.learning, data)
    return data


def publish(workspace: Workspace, scenario: Scenario, version: str | None, force: bool = False) -> PublishedRun:
    """Publish the dataset and the map, each under a version of its own; the same content is not published twice.

    `version` is the map's. The dataset's is the next free one of its folder, and the map names it. Raises PublishError
    for a map beyond the scenario's limits; with `force` it is published, and its card says so.
    """
    import pandas as pd

    from gaitflow.atlas.patterns import map_symmetry
    from gaitflow.dataset import load_solutions
    from gaitflow.learn.warmstarts import region_means
    from gaitflow.pipeline.chances import learning_of
    from gaitflow.problem import transcribe
    from gaitflow.publishing import Parts, PublishError
    from gaitflow.publishing import publish as publish_map
    from gaitflow.publishing.dataset import publish_dataset
    from gaitflow.publishing.judge_map import BEYOND, disregarded, faults_of_certificate, faults_of_map, outdated
    from gaitflow.solvers.options import IPOPT_WARM
    from gaitflow.tables.provenance import made_by

    run = workspace.run(scenario)
    need(run.learning, f"gaitflow train {scenario.name}")
    need(run.atlas_record, f"gaitflow atlas {scenario.name}")
    learning, record = read_json(run.learning), read_json(run.atlas_record)
    path = workspace.results / f"certificate-{scenario.name}.json"
    certificate = read_json(path) if path.exists() else None
    remark = certificate and disregarded(certificate, scenario.problem_digest)
    faults = faults_of_map(scenario.limits, learning, None if remark else certificate)
    judged = {}
    if scenario.tasks.adaptive is not None:
        del record["feasible"]
        judged = {"certificate": record.pop("certificate"), "sampling": record.pop("curve")}
        outdated_since = outdated(judged["certificate"], learning_of(scenario))
        misses = faults_of_certificate(scenario.tasks.adaptive, judged["certificate"])
        faults += [outdated_since] if outdated_since else misses
    if faults and not force:
        told = "; ".join(faults)
        raise PublishError(
            f"{scenario.name}: {told}: nothing was published; --force publishes it, and the card says so"
        )
    labels, problem = pd.read_parquet(run.labels), transcribe(scenario)
    starts = region_means(labels, load_solutions(run.solutions), problem.layout.pack, map_symmetry(scenario))
    known, gaits = atlas_of(run, scenario)
    dataset = publish_dataset(workspace.datasets, run.solutions, run.labels, run.gait_costs)
    parts = Parts(
        problem=problem,
        feasible=domain_of(run, scenario, labels).feasible,
        classifier=run.classifier.read_bytes(),
        classifier_kind=learning["method"],
        classes=learning["classes"],
        starts=[start for start in starts if start.gait in learning["classes"]],
        atlas=known.of([gaits.index(gait) for gait in learning["classes"]]),
        dataset={"name": scenario.name, "version": dataset.name},
        code=made_by(),
        metrics=learning | {"atlas": record} | judged | ({BEYOND: faults} if faults else {}),
        solver_options=IPOPT_WARM,
    )
    model = publish_map(workspace.models, parts, version)
    done = PublishedRun(model.name, dataset, model, (f"{path}: {remark}",) if remark else ())
    write_json(run.published, {"version": done.version, "dataset": str(dataset), "model": str(model)})
    return done


def report(workspace: Workspace, scenario: Scenario) -> list[Path]:
    """Draw the report of a run: figures and one page."""
    import pandas as pd

    from gaitflow.dataset import load_solutions
    from gaitflow.report.certificate import SamplingRecord
    from gaitflow.report.report import write_report
    from gaitflow.runtime import GaitMap

    run = workspace.run(scenario)
    need(run.labels, f"gaitflow label {scenario.name}")
    solutions = load_solutions(run.solutions)
    gait_map = GaitMap.load(read_json(run.published)["model"]) if run.published.exists() else None
    sampled = None if scenario.tasks.adaptive is None else read_json(run.sampled_record)
    return write_report(
        run.report,
        scenario,
        pd.read_parquet(run.labels),
        list(solutions),
        [gait.name for gait in gait_map.gaits] if gait_map else [],
        (lambda values: gait_map.select_many(**values).index) if gait_map else None,
        read_json(run.learning) if run.learning.exists() else None,
        solutions.record,
        None if sampled is None else SamplingRecord(sampled["certificate"], sampled["curve"]),
    )


def summary(scenario: Scenario) -> dict[str, Any]:
    """What a scenario asks for, in a few numbers."""
    from gaitflow.config.tasks import tasks_of
    from gaitflow.problem import transcribe
    from gaitflow.search.exhaustive import candidate_patterns
    from gaitflow.store.units import plan_units

    problem, tasks = transcribe(scenario), tasks_of(scenario)
    return {
        "scenario": scenario.name,
        "robot": scenario.robot.name,
        "tasks": len(tasks),
        "patterns": max(len(candidate_patterns(scenario, task)) for task in tasks),
        "units": len(plan_units(scenario)),
        "variables": problem.layout.nw,
        "rows": problem.ng,
        "digest": digest_of(scenario.as_data()),
    }
