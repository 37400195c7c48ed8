"""Scenarios to solve, and two gaits of a small planar problem, solved."""

from __future__ import annotations

from to_solve import anymal, coarse, effort, solve
from two_gaits import evaluated, problem, program, solved, solver

__all__ = ["anymal", "coarse", "effort", "evaluated", "problem", "program", "solve", "solved", "solver"]
