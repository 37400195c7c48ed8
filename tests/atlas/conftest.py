"""The nodes of the small real map, its problem, and the seeds that they grow from."""

from tiny_map import grown, preferring, tiny

__all__ = ["grown", "preferring", "tiny"]
