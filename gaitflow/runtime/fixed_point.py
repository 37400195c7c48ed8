"""Numbers as whole ones of two bytes times a power of two: half of the bytes of single precision.

What matters of a start is how far it is off, not by which share. So all numbers along an axis of an array have one
power of two, such that the largest is just a whole number of two bytes. In half precision, which has as many bytes, the
larger numbers are off by thirty times as much, and plans of ANYmal take one iteration of nine more.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

WHOLE = 32767  # the largest of two bytes
MOST = 100  # exponents: of what single precision can have


def fixed_point(numbers: NDArray[Any], axis: int) -> tuple[NDArray[np.int16], NDArray[np.int16]]:
    """Whole numbers and exponents; these have length 1 along `axis`, whose numbers share one."""
    largest = np.abs(numbers).max(axis=axis, keepdims=True, initial=0.0).astype(np.float64)
    exponents = np.ceil(np.log2(np.maximum(largest, 2.0**-MOST) / WHOLE)).clip(-MOST, MOST).astype(np.int16)
    whole = np.rint(np.ldexp(numbers.astype(np.float64), -exponents)).clip(-WHOLE, WHOLE)
    return whole.astype(np.int16), exponents


def single(whole: NDArray[np.int16], exponents: NDArray[np.int16]) -> NDArray[np.float32]:
    """The numbers in single precision, which has all of them; infinite for exponents that are too large."""
    with np.errstate(over="ignore"):
        numbers: NDArray[np.float32] = np.ldexp(whole.astype(np.float32), exponents)
    return numbers


def rounded(numbers: NDArray[Any], axis: int) -> NDArray[np.float32]:
    """What `fixed_point` keeps of numbers."""
    return single(*fixed_point(numbers, axis))
