"""The small real map."""

from tiny_map import pristine, tiny

__all__ = ["pristine", "tiny"]
