"""The atlas of a map over a grid, grown from its labelled solutions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gaitflow.atlas.compress import build_atlas
from gaitflow.atlas.fill import fill
from gaitflow.atlas.grow import grow
from gaitflow.atlas.judge import judge_predictions
from gaitflow.atlas.patterns import full_patterns, map_symmetry
from gaitflow.atlas.settle import known_costs, settle
from gaitflow.config.scenario import Scenario
from gaitflow.core.domain import Domain
from gaitflow.core.gaits import Pattern
from gaitflow.dataset.read import Solutions
from gaitflow.execute.display import display
from gaitflow.execute.node_processes import node_processes
from gaitflow.execute.progress import countdown
from gaitflow.pipeline.atlas_record import atlas_record
from gaitflow.problem import transcribe
from gaitflow.runtime.atlas_file import atlas_bytes

if TYPE_CHECKING:
    import pandas as pd


def grown(
    scenario: Scenario, labels: pd.DataFrame, costs: pd.DataFrame, solutions: Solutions, domain: Domain, workers: int
) -> tuple[bytes, dict[str, Any]]:
    """The atlas of every labelled gait as its file's bytes, and its record: how good its predictions are.

    `labels` and `costs` are of `solutions`; `workers` processes solve the nodes.
    """
    tolerance = scenario.learning.tie_tolerance
    solved = labels[(labels["split"] == "grid") & (labels["status"] == "solved")]
    gaits = sorted(solved["label"].unique().tolist())
    patterns = full_patterns(solutions.frame(), costs, gaits, tolerance, map_symmetry(scenario))
    numbers = [gaits.index(gait) for gait in patterns.values()]
    problem = transcribe(scenario)
    with display(f"{scenario.name}: atlas") as tell, node_processes(scenario, workers) as each:
        tell("reading the solutions")
        full = [Pattern.from_text(pattern) for pattern in patterns]
        growth = grow(problem, full, solutions, domain, lambda nodes: tell(f"{nodes} nodes on the grid"), each)
        fill(growth, lambda: build_atlas(growth, numbers), tolerance, on_test=countdown(tell, "tests"))
        missed = settle(
            growth, numbers, known_costs(costs, "gait", gaits, scenario.tasks.space.ranged), tolerance, tell
        )
        tell("put together")
        built = build_atlas(growth, numbers)
        content = atlas_bytes(built)
        judged = judge_predictions(growth, built)
    return content, atlas_record(gaits, built, len(content), judged, growth.solver.solves, missed)
