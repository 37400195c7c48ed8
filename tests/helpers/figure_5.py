"""The paper's Fig. 5: the gaits of a front and a hind leg, their equal neighbouring phases merged."""

from __future__ import annotations

FIGURE_5 = {
    "walking": ("0111", "1101"),
    "gallop": ("0110", "1100"),
    "bounding": ("0001", "0100"),
    "pronking": ("0110", "0100"),
    "gallop-walk": ("011", "110"),
    "gallop-pronk": ("010", "110"),
    "gallop-bound": ("010", "100"),
}
