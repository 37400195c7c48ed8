"""The solvers of a map: the problem is built once, when first needed, and each thread solves it with its own."""

from __future__ import annotations

import threading

from gaitflow.runtime.artifact import Artifact
from gaitflow.runtime.problem import Problem
from gaitflow.runtime.refine import Refiner
from gaitflow.runtime.switching import TransitionPlanner, TransitionProblem


class ThreadSolvers:
    """What plans the motions of an artifact, and the transitions between motions, in the thread that asks."""

    def __init__(self, artifact: Artifact, trust_code: bool) -> None:
        self._artifact = artifact
        self._trust_code = trust_code
        self._building = threading.Lock()
        self._of_thread = threading.local()
        self._problem: Problem | None = None
        self._transitions: TransitionProblem | None = None

    def refiner(self) -> Refiner:
        """This thread's solver of motions. Raises ImportError without CasADi, ArtifactError without its problem."""
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
