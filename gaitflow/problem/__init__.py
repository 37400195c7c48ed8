"""The gait problem, eq. (2)-(10) of the paper: one module for each physical term. No module touches files."""

from gaitflow.problem.bounds import Bounds
from gaitflow.problem.separable import SeparableProblem
from gaitflow.problem.transcription import GaitProblem, transcribe

__all__ = ["Bounds", "GaitProblem", "SeparableProblem", "transcribe"]
