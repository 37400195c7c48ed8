"""A robot as the paper sees it (section III.A): one rigid body, massless legs, a box for each foot."""

from __future__ import annotations

from pathlib import Path
from reprlib import repr as short
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from gaitflow.config.file import Config, read_yaml
from gaitflow.config.frames import Frames
from gaitflow.config.limbs import Limb
from gaitflow.core.names import quadruped_places

ROUNDING = 1e-6  # relative, of the digits that a robot's moments are written with
Positive = Annotated[float, Field(gt=0)]


class Leg(Config):
    """One leg: its letter in gait diagrams and its default foot position in the base frame [m]."""

    name: Annotated[str, Field(pattern=r"^[A-Z]{1,3}$")]
    default_foot: tuple[float, ...]


class Robot(Config):
    """Single-rigid-body parameters, SI units, base frame at the centre of mass (x forward, z up).

    In the plane (`dimension: 2`) vectors are (x, z), the inertia is the one pitch moment [kg m^2] and
    pitch is positive nose up. In space vectors are (x, y, z) and the inertia is 3 rows of 3.
    """

    name: Annotated[str, Field(pattern=r"^[a-z0-9_]+$")]
    dimension: Literal[2, 3]
    mass: Positive
    inertia: tuple[tuple[float, ...], ...]
    legs: Annotated[tuple[Leg, ...], Field(min_length=1, max_length=8)]
    box: tuple[Positive, ...]  # half lengths b of the kinematic box, eq. (5) [m]
    max_force: Positive  # normal force of one foot [N]
    max_foot_speed: Positive  # along each axis [m/s]
    max_tilt: Annotated[float, Field(gt=0, lt=1.5)]  # along each angle [rad]
    mirror: tuple[tuple[str, str], ...] = ()  # left-right pairs of legs that swap in a mirror image; a quadruped's two
    source: str = ""  # where the numbers come from
    frames: Frames | None = None  # of the description that it comes from; a robot in space has them
    limbs: tuple[Limb, ...] | None = None  # how its legs are built; what an objective of energy needs

    @model_validator(mode="after")
    def _shapes_agree(self) -> Robot:
        d = self.dimension
        rows = 1 if d == 2 else 3
        if [len(row) for row in self.inertia] != [rows] * rows:
            raise ValueError(
                f"inertia = {short(self.inertia)}: must be {rows} row(s) of {rows} number(s) when dimension is {d}"
            )
        inertia = np.array(self.inertia)
        moments = np.linalg.eigvalsh(inertia)
        if not np.allclose(inertia, inertia.T) or moments[0] <= 0:
            raise ValueError(f"inertia = {self.inertia}: must be symmetric and positive definite [kg m^2]")
        if d == 3 and moments[2] > (moments[0] + moments[1]) * (1 + ROUNDING):
            raise ValueError(
                f"inertia: its principal moments are {' and '.join(f'{moment:.4g}' for moment in moments)} kg m^2: no "
                "body has one that is larger than the sum of the other two"
            )
        if len(self.box) != d:
            raise ValueError(f"box = {short(self.box)}: must have {d} half lengths when dimension is {d}")
        for leg in self.legs:
            if len(leg.default_foot) != d:
                raise ValueError(
                    f"legs.{leg.name}.default_foot = {short(leg.default_foot)}: must have {d} coordinates when "
                    f"dimension is {d}"
                )
            if leg.default_foot[-1] + self.box[-1] >= 0:
                raise ValueError(
                    f"legs.{leg.name}.default_foot = {leg.default_foot}: with box = {self.box} the foot's box reaches "
                    f"up to the base; its z must be below {-self.box[-1]:g}"
                )
        names = [leg.name for leg in self.legs]
        if len(set(names)) != len(names):
            raise ValueError(f"legs: names = {names}: each must differ from the others")
        paired = [name for pair in self.mirror for name in pair]
        if len(set(paired)) != len(paired) or not set(paired) <= set(names):
            raise ValueError(
                f"mirror = {short(self.mirror)}: pairs of legs, none in two pairs or paired with itself; "
                f"allowed: {', '.join(names)}"
            )
        self._has_a_quadrupeds_mirror()
        if self.mirror:
            self._is_its_own_mirror_image()
        return self

    def _has_a_quadrupeds_mirror(self) -> None:
        """A quadruped's gaits are named up to left and right, so it may have no more gaits than that."""
        places = quadruped_places(self.leg_names)
        if places is None:
            return
        left_front, right_front, left_hind, right_hind = (self.leg_names[place] for place in places)
        pairs = {frozenset((left_front, right_front)), frozenset((left_hind, right_hind))}
        if set(map(frozenset, self.mirror)) != pairs:
            raise ValueError(
                f"mirror = {short(self.mirror)}: must be [[{left_front}, {right_front}], [{left_hind}, {right_hind}]] "
                f"for legs called {', '.join(self.leg_names)}, whose gaits share a name with their mirror images; for "
                "a body that is not left-right symmetric call the legs otherwise"
            )

    def _is_its_own_mirror_image(self) -> None:
        """Gaits are merged under mirroring, which is right only for a body that is its own image to the last bit."""
        feet = {leg.name: leg.default_foot for leg in self.legs}
        partner = {a: b for a, b in self.mirror} | {b: a for a, b in self.mirror}
        for name, foot in feet.items():
            other = partner.get(name, name)
            image = feet[other] if self.dimension == 2 else (feet[other][0], -feet[other][1], feet[other][2])
            if foot == image:
                continue
            expected = f"the mirror image of {other}'s" if other != name else "in the middle plane, as it is in no pair"
            raise ValueError(
                f"legs.{name}.default_foot = {foot}: must be {expected}, {image}, when mirror = {self.mirror}"
            )
        if self.dimension == 3 and any(self.inertia[i][j] for i, j in ((0, 1), (1, 0), (1, 2), (2, 1))):
            raise ValueError(
                f"inertia: Ixy = {self.inertia[0][1]:g} and Iyz = {self.inertia[1][2]:g}: must be 0 when mirror = "
                f"{self.mirror}"
            )

    @model_validator(mode="after")
    def _frames_fit(self) -> Robot:
        if self.frames is None:
            return self
        if self.dimension == 2:
            raise ValueError("frames: need a robot with dimension 3; leave them out")
        named = tuple(foot.leg for foot in self.frames.feet)
        if named != self.leg_names:
            raise ValueError(
                f"frames.feet: are of the legs {short(named)}; allowed is one a leg, in their order: "
                f"{', '.join(self.leg_names)}"
            )
        return self

    @model_validator(mode="after")
    def _limbs_fit(self) -> Robot:
        if self.limbs is None:
            return self
        if self.dimension == 2:
            raise ValueError("limbs: need a robot with dimension 3; leave them out")
        named = tuple(limb.leg for limb in self.limbs)
        if named != self.leg_names:
            raise ValueError(
                f"limbs: are of the legs {short(named)}; allowed is one a leg, in their order: "
                f"{', '.join(self.leg_names)}"
            )
        for limb, leg in zip(self.limbs, self.legs, strict=True):
            self._reaches(limb, np.array(leg.default_foot))
        partner = {a: b for a, b in self.mirror}
        for limb in self.limbs:
            other = partner.get(limb.leg)
            if other is not None and self.limbs[named.index(other)] != limb.mirrored(other):
                raise ValueError(
                    f"limbs: {other}'s must be the mirror image of {limb.leg}'s when mirror = {self.mirror}"
                )
        return self

    def _reaches(self, limb: Limb, foot: np.ndarray[Any, Any]) -> None:
        """A limb must hold its default foot with a bent knee."""
        x, y, z = foot - np.array(limb.hip)
        square = y**2 + z**2 - limb.aside**2
        length = np.hypot(x, np.sqrt(max(square, 0.0)) - limb.below)
        if square <= 0 or not abs(limb.thigh - limb.shank) < length < limb.thigh + limb.shank:
            raise ValueError(
                f"limbs: {limb.leg}'s default foot is {length:.3f} m from its hip; a thigh of {limb.thigh:g} m and a "
                f"shank of {limb.shank:g} m do not hold it there"
            )

    @model_serializer(mode="wrap")
    def _without_unknown(self, data: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Robots without frames or limbs are the same data as before there were any."""
        found: dict[str, Any] = data(self)
        unknown = [key for key in ("frames", "limbs") if getattr(self, key) is None]
        return {key: value for key, value in found.items() if key not in unknown}

    @property
    def leg_names(self) -> tuple[str, ...]:
        """Leg letters in the order of every legs axis."""
        return tuple(leg.name for leg in self.legs)

    @property
    def mirror_permutation(self) -> tuple[int, ...]:
        """For each leg the index of the leg that takes its place in the mirror image."""
        swap = {a: b for a, b in self.mirror} | {b: a for a, b in self.mirror}
        return tuple(self.leg_names.index(swap.get(name, name)) for name in self.leg_names)

    @property
    def reversal_permutation(self) -> tuple[int, ...] | None:
        """For each leg the index of the leg in its place when the body faces the other way; None when it is not alike.

        Front and hind swap, left and right stay: time run backwards by such a body is a motion forwards.
        """
        feet = [leg.default_foot for leg in self.legs]
        images = [(-foot[0], *foot[1:]) for foot in feet]
        if any(image not in feet for image in images) or len(set(feet)) != len(feet):
            return None
        if self.dimension == 3 and any(self.inertia[0][other] for other in (1, 2)):
            return None
        return tuple(feet.index(image) for image in images)


def load_robot(path: Path) -> Robot:
    """Read a robots YAML. Raises ConfigError that names the file, field, value and what is allowed."""
    return Robot.from_data(read_yaml(path), str(path))
