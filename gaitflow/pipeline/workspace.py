"""Where a project keeps what: scenario files in, run state, published datasets and models out."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gaitflow import shipped
from gaitflow.config.file import ConfigError, meant
from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.config.sweep import Sweep, load_sweep


@dataclass(frozen=True)
class Run:
    """The folder of one scenario's run and the files that its stages hand on."""

    folder: Path

    @property
    def solutions(self) -> Path:
        """Every solve of the scenario, collected from the store."""
        return self.folder / "solutions.parquet"

    @property
    def rounds(self) -> Path:
        """The tasks that an adaptive sampling has chosen, round by round."""
        return self.folder / "sampling" / "rounds.json"

    @property
    def solved_nodes(self) -> Path:
        """The nodes that an adaptive sampling has solved so far; removed, they are solved again."""
        return self.folder / "sampling" / "nodes.sqlite"

    @property
    def earlier_atlas(self) -> Path:
        """The atlas of the published map whose nodes an adaptive sampling began with; see `earlier_map`."""
        return self.folder / "sampling" / "earlier.safetensors"

    @property
    def sampled_atlas(self) -> Path:
        """The atlas that an adaptive sampling ended with; what it says of it in `sampled_record`."""
        return self.folder / "sampling" / "atlas.safetensors"

    @property
    def sampled_record(self) -> Path:
        """The gaits and the domain of the sampled atlas, its certificate, and how it got there."""
        return self.folder / "sampling" / "sampling.json"

    @property
    def labels(self) -> Path:
        """The best gait of each task."""
        return self.folder / "labels.parquet"

    @property
    def gait_costs(self) -> Path:
        """The least cost of each gait at each task."""
        return self.folder / "gait_costs.parquet"

    @property
    def learning(self) -> Path:
        """How the classifiers did, and which one won."""
        return self.folder / "learning" / "learning.json"

    @property
    def classifier(self) -> Path:
        """The classifier that won, as ONNX."""
        return self.folder / "learning" / "classifier.onnx"

    @property
    def atlas(self) -> Path:
        """Solved tasks of every gait, from which costs and starts are predicted; its gaits in `atlas_record`."""
        return self.folder / "learning" / "atlas.safetensors"

    @property
    def atlas_record(self) -> Path:
        """The gaits of the atlas, in its order, how large it is, and how good its predictions are."""
        return self.folder / "learning" / "atlas.json"

    @property
    def published(self) -> Path:
        """Which dataset and model the run was published as."""
        return self.folder / "published.json"

    @property
    def report(self) -> Path:
        """The folder of the report."""
        return self.folder / "report"


@dataclass(frozen=True)
class SweepRun:
    """The folder of one scenario's sweep, with the units of all its robots, and its files."""

    folder: Path

    @property
    def table(self) -> Path:
        """The labels of every robot."""
        return self.folder / "sweep.parquet"

    @property
    def robots(self) -> Path:
        """The robots that were sampled."""
        return self.folder / "robots.json"


@dataclass(frozen=True)
class Workspace:
    """A folder where `runs/`, `datasets/` and `models/` grow; what is in its `configs/` comes before what ships."""

    root: Path

    @property
    def datasets(self) -> Path:
        """Published datasets, a folder a scenario."""
        return self.root / "datasets"

    @property
    def models(self) -> Path:
        """Published maps, a folder a scenario."""
        return self.root / "models"

    @property
    def results(self) -> Path:
        """Documents of the benches."""
        return self.root / "docs" / "results"

    def run(self, scenario: Scenario) -> Run:
        """The run of a scenario."""
        return Run(self.root / "runs" / scenario.name)

    def scenario(self, name: str) -> Scenario:
        """The scenario called `name` in configs/scenarios or among those that ship, or in a YAML file of that path.

        A robot of the workspace comes before one of the same name that ships.
        Raises ConfigError when there is none, listing those there are, and when the file cannot be used.
        """
        file = self._file("scenario", name, shipped.SCENARIOS)
        scenario = load_scenario(file, self.root / "configs" / "robots")
        if not is_path(name) and scenario.name != name:
            raise ConfigError(f"{file}: name = {scenario.name!r}: must be {name!r}, as the file is called")
        return scenario

    def sweep_run(self, scenario: str, sweep: Sweep) -> SweepRun:
        """The run of a sweep over the scenario of that name."""
        return SweepRun(self.root / "runs" / f"{scenario}-{sweep.name}")

    def sweep(self, name: str) -> Sweep:
        """The sweep called `name` in configs/sweeps or among those that ship, or in a YAML file of that path.

        Raises ConfigError as `scenario` does.
        """
        file = self._file("sweep", name, shipped.SWEEPS)
        sweep = load_sweep(file)
        if not is_path(name) and sweep.name != name:
            raise ConfigError(f"{file}: name = {sweep.name!r}: must be {name!r}, as the file is called")
        return sweep

    def _file(self, kind: str, name: str, ships: Path) -> Path:
        if is_path(name):
            return Path(name)
        own = self.root / "configs" / f"{kind}s"
        known = {file.stem: file for folder in (ships, own) for file in folder.glob("*.yaml")}
        if name not in known:
            raise ConfigError(
                f"{kind} {name!r}: neither in {own} nor one that ships{meant(name, known)} there are "
                f"{', '.join(sorted(known))}; a path ending in .yaml works too"
            )
        return known[name]


def is_path(name: str) -> bool:
    """Whether a scenario is named by the path of its file."""
    return name.endswith((".yaml", ".yml"))


def from_anywhere(name: str) -> str:
    """The same scenario for a process in another folder: its name, or the whole path of its file."""
    return str(Path(name).resolve()) if is_path(name) else name
