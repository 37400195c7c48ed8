"""How a leg is built: hip abduction about x, then hip flexion and knee about the leg's own y; what energy needs."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from gaitflow.config.file import Config

Length = Annotated[float, Field(gt=0, lt=3)]  # m
Mass = Annotated[float, Field(gt=0)]  # kg
Moment = Annotated[float, Field(gt=0)]  # kg m^2


class Limb(Config):
    """One leg's joints, lengths in m, in the base frame at the centre of mass; see `gaitflow.problem.limb`.

    The foot is where plans have it. The leg's plane goes through thigh and shank, beside the abduction axis.
    """

    leg: str
    hip: tuple[float, float, float]  # x of the flexion axis, y and z of the abduction axis
    aside: float  # of the leg's plane from the abduction axis, to the left
    below: float  # of the flexion axis below the abduction axis, in the plane
    thigh: Length
    shank: Length  # from the knee to the foot
    knee: Literal["forward", "backward"]  # of the line from hip to foot
    mass: Mass  # of all that swings with the leg
    abduction_inertia: Moment  # of the leg about its abduction axis, standing
    flexion_inertia: tuple[tuple[float, float], tuple[float, float]]  # of thigh and shank about hip flexion and knee

    @model_validator(mode="after")
    def _is_a_mass(self) -> Limb:
        inertia = np.array(self.flexion_inertia)
        if inertia[0, 1] != inertia[1, 0] or np.linalg.eigvalsh(inertia)[0] <= 0:
            raise ValueError(
                f"flexion_inertia = {self.flexion_inertia}: must be symmetric and positive definite [kg m^2]"
            )
        return self

    def mirrored(self, leg: str) -> Limb:
        """Its mirror image, as another leg."""
        x, y, z = self.hip
        return self.model_copy(update={"leg": leg, "hip": (x, -y + 0.0, z), "aside": -self.aside + 0.0})
