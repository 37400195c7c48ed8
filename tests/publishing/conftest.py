"""The small real map that the tests of the artifact and of the runtime share."""

from tiny_map import artifact, grown, parts, preferring, pristine

__all__ = ["artifact", "grown", "parts", "preferring", "pristine"]
