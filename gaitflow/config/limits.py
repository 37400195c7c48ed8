"""Limits of a map's errors: a map beyond them is not published."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from gaitflow.config.file import Config

Share = Annotated[float, Field(ge=0, le=1)]


class Limits(Config):
    """What a map's picks on held-out tasks, and its labels by the certificate, may be off by; all are shares.

    A map beyond one of them is published only when forced, and its card says so.
    """

    regret_mean: Share = 0.02  # of the picks: cost over the least cost, less 1
    infeasible_rate: Share = 0.2  # picks without a known motion
    certificate_gap: Share = 0.01  # the label's cost over that of an exhaustive search, less 1, at its worst task
