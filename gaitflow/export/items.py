"""What map.bin is made of: counts, texts and arrays, each padded with zeros to a multiple of 8 bytes."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

ALIGNMENT = 8


def counts(*numbers: int) -> bytes:
    """Unsigned integers of 8 bytes, little-endian as all numbers."""
    return struct.pack(f"<{len(numbers)}Q", *numbers)


def text(content: str) -> bytes:
    """The number of bytes, and the text in UTF-8."""
    encoded = content.encode()
    return counts(len(encoded)) + _padded(encoded)


def array(values: Sequence[object] | NDArray[np.generic], kind: str) -> bytes:
    """Numbers of a numpy kind, such as "<f8", the last index fastest."""
    return _padded(np.ascontiguousarray(values, dtype=kind).tobytes())


def _padded(content: bytes) -> bytes:
    return content + bytes(-len(content) % ALIGNMENT)
