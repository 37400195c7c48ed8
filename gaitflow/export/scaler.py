"""The scaler in front of a forest and of support vectors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gaitflow.export.graph import Floats, Graph
from gaitflow.export.items import array


@dataclass(frozen=True)
class Scaler:
    """(x - offset) * scale, both [axes]."""

    offset: Floats
    scale: Floats

    def items(self) -> Iterator[bytes]:
        """What map.bin says of it."""
        yield array(self.offset, "<f4")
        yield array(self.scale, "<f4")


def read_scaler(graph: Graph, value: str) -> Scaler:
    """The scaler that makes a value from the graph's input. Raises CannotExport for anything else."""
    node = graph.node(value, "Scaler")
    graph.expect_input(node.input[0])
    found = graph.attributes(node, "offset", "scale")
    scaler = Scaler(np.array(found["offset"], dtype=np.float32), np.array(found["scale"], dtype=np.float32))
    if scaler.offset.shape != scaler.scale.shape:
        raise graph.refuse(f"{scaler.offset.size} offsets and {scaler.scale.size} scales of the axes")
    return scaler
