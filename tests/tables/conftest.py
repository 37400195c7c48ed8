"""A small planar scenario, its units, and solutions with arrays of its shapes."""

from small_units import make_solutions, scenario, store, units

__all__ = ["make_solutions", "scenario", "store", "units"]
