"""The small real map that the tests of this folder share with those of the artifact."""

from tiny_map import artifact, grown, preferring, pristine, tiny

__all__ = ["artifact", "grown", "preferring", "pristine", "tiny"]
