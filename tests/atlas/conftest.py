"""The nodes of the small real map."""

from tiny_map import grown, judged, parts

__all__ = ["grown", "judged", "parts"]
