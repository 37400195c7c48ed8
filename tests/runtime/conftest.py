"""The small real map that the tests of this folder share with those of the artifact."""

from tiny_map import artifact, grown, parts, preferring, pristine

__all__ = ["artifact", "grown", "parts", "preferring", "pristine"]
