"""A program in pieces that are copies of one another: all steps, and the reach of a leg at the end of every phase.

A piece is derived once and evaluated for each copy. With 40 steps their code is a fortieth of that of one expression.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array


@dataclass(frozen=True, eq=False)
class Copies:
    """Terms that are copies of one, whose `function` is (x [n], data [c], task [axes]) -> (cost [1], rows [m]).

    places [copies, n] of w and data [copies, c] are its arguments, rows [copies, m] the places of its rows.
    """

    function: ca.Function
    places: NDArray[np.intp]
    data: Array
    rows: NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Pieces:
    """Copies, and `rest`, (w [nw], task [axes]) -> (cost [1], rows [ng]), with rows of 0 where copies have theirs."""

    copies: tuple[Copies, ...]
    rest: ca.Function
