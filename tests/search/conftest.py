"""Scenarios to solve."""

from to_solve import anymal, coarse, effort, solve

__all__ = ["anymal", "coarse", "effort", "solve"]
