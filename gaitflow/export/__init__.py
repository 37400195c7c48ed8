"""A published map for planners that are not Python: the problem as C, everything else as one file of data."""

from gaitflow.export.export import Exported, export_c
from gaitflow.export.graph import CannotExport

__all__ = ["CannotExport", "Exported", "export_c"]
