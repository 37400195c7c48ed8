"""A small planar scenario."""

from small_units import scenario

__all__ = ["scenario"]
