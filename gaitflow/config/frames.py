"""Where a robot's links are, relative to a plan's centre of mass and feet; no part of the problem."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from gaitflow.config.file import Config

Link = Annotated[str, Field(min_length=1, max_length=200)]
Vector = tuple[float, float, float]


class FootFrame(Config):
    """A leg's foot: the link whose origin is the foot of every plan, and where it touches the ground.

    contact_point [m] is in the link's frame, in the standing pose.
    """

    leg: str
    link: Link
    contact_point: Vector


class Frames(Config):
    """The base link, whose axes are the base frame's, the centre of mass in it [m], and the feet in the legs' order."""

    base_link: Link
    com_in_base: Vector
    feet: tuple[FootFrame, ...]
