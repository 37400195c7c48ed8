"""The solvers of a map: the problem is built once, when first needed, and each thread solves it with its own."""

from __future__ import annotations

import threading
from pathlib import Path

from gaitflow.runtime.artifact import Artifact
from gaitflow.runtime.attempt import GaitRefiner
from gaitflow.runtime.compiled import CompiledMap
from gaitflow.runtime.problem import Problem
from gaitflow.runtime.refine import Refiner
from gaitflow.runtime.switching import TransitionPlanner, TransitionProblem


class ThreadSolvers:
    """What plans the motions of an artifact, and the transitions between motions, in the thread that asks."""

    def __init__(self, artifact: Artifact, trust_code: bool, compiled: Path | None = None) -> None:
        """`compiled`: the folder of an export that was built. Raises ArtifactError where it is not of this map."""
        self._artifact = artifact
        self._compiled = None if compiled is None else CompiledMap(compiled, artifact)
        self._trust_code = trust_code
        self._building = threading.Lock()
        self._of_thread = threading.local()
        self._problem: Problem | None = None
        self._transitions: TransitionProblem | None = None

    def fastest(self) -> GaitRefiner:
        """This thread's solver of motions, the compiled one where there is one. Raises as `refiner`."""
        if self._compiled is None:
            return self.refiner()
        fastest: GaitRefiner | None = getattr(self._of_thread, "fastest", None)
        if fastest is None:
            fastest = self._of_thread.fastest = self._compiled.refiner(self._artifact, self.refiner)
        return fastest

    def refiner(self) -> Refiner:
        """This thread's solver by CasADi. Raises ImportError without it, ArtifactError without the map's problem."""
        refiner: Refiner | None = getattr(self._of_thread, "refiner", None)
        if refiner is None:
            artifact = self._artifact
            with self._building:
                if self._problem is None:
                    rows = artifact.tensors.rows
                    self._problem = Problem(artifact.folder, artifact.manifest, rows, self._trust_code)
                refiner = Refiner(self._problem, artifact.manifest, artifact.tensors, artifact.atlas)
            self._of_thread.refiner = refiner
        return refiner

    def transition_planner(self) -> TransitionPlanner:
        """This thread's solver of transitions. Raises ImportError without CasADi."""
        planner: TransitionPlanner | None = getattr(self._of_thread, "planner", None)
        if planner is None:
            with self._building:
                if self._transitions is None:
                    self._transitions = TransitionProblem(self._artifact.manifest.scenario)
                planner = TransitionPlanner(self._transitions)
            self._of_thread.planner = planner
        return planner
