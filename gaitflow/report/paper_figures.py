"""The paper's Fig. 4 to 10 anew, from published datasets and maps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from gaitflow.config.scenario import Scenario
from gaitflow.dataset.labels_file import read_labels
from gaitflow.dataset.read import load_solutions
from gaitflow.files import atomic_write
from gaitflow.publishing.find import dataset_folder
from gaitflow.report.claims import EXACT, FIGURES
from gaitflow.report.gait_diagrams import draw_gait_diagrams
from gaitflow.report.gait_map import draw_gait_map
from gaitflow.report.motion import draw_motion
from gaitflow.report.palette import gait_colours
from gaitflow.report.report import png_of
from gaitflow.report.state_space import draw_state_space
from gaitflow.report.stored import scenario_of
from gaitflow.report.winners import by_size, central, winners
from gaitflow.runtime import GaitMap
from gaitflow.runtime.versions import versions_in
from gaitflow.search.solution import Solution

RULES = {"euler": FIGURES, "exact": EXACT}
FIG_6 = ("walking", "gallop-walk")
FIG_9 = ("three-beat", "walking trot", "four-beat", "running trot")  # what the names of its gaits begin with
FIG_10 = "running trot"


@dataclass(frozen=True)
class PublishedMap:
    """The newest map of a scenario, and the dataset that it was learnt from; regions: the motions that win, by gait."""

    scenario: Scenario
    labels: pd.DataFrame
    regions: dict[str, list[Solution]]
    gait_map: GaitMap

    @classmethod
    def load(cls, name: str, datasets: Path, models: Path) -> PublishedMap:
        """Raises ValueError where one of both is not there, and as `load_solutions` and `GaitMap.load` do."""
        versions = versions_in(models / name)
        if not versions:
            raise ValueError(f"{models / name}: no published version; the figures need those of {name}")
        folder = models / name / str(versions[-1])
        dataset = dataset_folder(folder, datasets)
        solutions, labels = load_solutions(dataset), read_labels(dataset).to_pandas()
        scenario = scenario_of(solutions)
        regions = winners(labels, solutions, scenario.tasks.space)
        return cls(scenario, labels, regions, GaitMap.load(folder))

    def map(self) -> Figure:
        """The gait map in the manner of Fig. 4 and 7."""
        gaits = [gait.name for gait in self.gait_map.gaits]
        title = self.scenario.description or self.scenario.name
        tasks = self.scenario.tasks
        return draw_gait_map(self.labels, gaits, lambda v: self.gait_map.select_many(**v).index, title, tasks)

    def state_space(self, gaits: Sequence[str]) -> Figure:
        """Trajectories of some gaits in the manner of Fig. 6 and 10."""
        return draw_state_space({name: self.regions.get(name, []) for name in gaits}, self.scenario.tasks.space)

    def motion(self, beginning: str) -> Figure:
        """Snapshots, as in Fig. 9, of the gait that wins most tasks of those whose names begin so."""
        name = next(name for name in by_size(self.labels) if name.startswith(beginning) and self.regions[name])
        colour = gait_colours(self.regions)[name]
        return draw_motion(central(self.regions[name]), self.scenario, name, colour)


def write_paper_figures(folder: Path, datasets: Path, models: Path) -> Iterator[Path]:
    """Write every figure twice, `fig-4a-euler.png` by the paper's integrator, `fig-4a-exact.png`; yields each path.

    Raises ValueError when a dataset or map is missing, WriteError when the disk refuses.
    """
    for rule, scenarios in RULES.items():
        maps = {figure: PublishedMap.load(name, datasets, models) for figure, name in scenarios.items()}
        for figure, drawn in _figures(maps):
            path = folder / f"fig-{figure}-{rule}.png"
            atomic_write(path, png_of(drawn))
            yield path


def _figures(maps: dict[str, PublishedMap]) -> Iterator[tuple[str, Figure]]:
    plane, space = [maps[figure] for figure in ("4a", "4b", "4c")], maps["7"]
    for figure in ("4a", "4b", "4c"):
        yield figure, maps[figure].map()
    yield "5", _diagrams(plane)
    yield "6", maps["4a"].state_space(FIG_6)
    yield "7", space.map()
    yield "8", _diagrams([space])
    for place, beginning in enumerate(FIG_9, start=1):
        yield f"9-{place}", space.motion(beginning)
    yield "10", space.state_space([FIG_10])


def _diagrams(maps: Sequence[PublishedMap]) -> Figure:
    """Every gait that wins a task of some maps of one robot, with the motions of the first map that has it."""
    regions: dict[str, list[Solution]] = {}
    for each in maps:
        regions = {name: region for name, region in each.regions.items() if region} | regions
    return draw_gait_diagrams(regions, maps[0].scenario.robot.leg_names, gait_colours(regions))
