"""What every test shares: one thread a process, no window for plots, repeatable property tests."""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MPLBACKEND", "Agg")

from pathlib import Path

import pytest
from hypothesis import settings

# No deadline: the cores are shared, so a slow example says nothing. Derandomized: a red run can be repeated.
settings.register_profile("gaitflow", deadline=None, derandomize=True)
settings.load_profile("gaitflow")


@pytest.fixture(scope="session")
def checkout() -> Path:
    """The root of the source tree."""
    return Path(__file__).resolve().parent.parent
