"""Joint torques and rates of a leg with hip abduction, hip flexion and knee, in closed form.

The foot decides the joints: the leg's plane holds the foot, the knee lies where thigh and shank meet. In the plane,
coordinates are x and z (away from the abduction axis, negative below it), and flexion is positive from x to z.
"""

from __future__ import annotations

from functools import cached_property

import casadi as ca

from gaitflow.config.limbs import Limb

# Where a solver looks out of reach on its way, numbers stay finite: the leg is as long as it has to be.
NEAREST = 1e-3  # m: of a foot to the abduction axis, below it
STRAIGHTEST = 0.01  # how far a knee is from the line from hip to foot, over that line


class LegPose:
    """A leg whose foot is at a place [3] m of the base frame, within its reach; no joint angle is needed."""

    def __init__(self, limb: Limb, foot: ca.SX) -> None:
        self._limb = limb
        self._side, self._height = foot[1] - limb.hip[1], foot[2] - limb.hip[2]
        aside = limb.aside
        depth = ca.fmax(self._side**2 + self._height**2 - aside**2, NEAREST**2)
        self._depth = ca.sqrt(depth)  # of the foot below the abduction axis
        span = self._side**2 + self._height**2
        self._cos = (aside * self._side - self._depth * self._height) / span
        self._sin = (self._depth * self._side + aside * self._height) / span
        self._x, self._z = foot[0] - limb.hip[0], limb.below - self._depth

    def torques(self, force: ca.SX) -> ca.SX:
        """Torques [3] N m that push with a force [3] N of the base frame on what the foot touches."""
        x, _, z = ca.vertsplit(self._in_plane(force))
        knee_x, knee_z = self._knee
        return ca.vertcat(
            self._side * force[2] - self._height * force[1],
            self._x * z - self._z * x,
            (self._x - knee_x) * z - (self._z - knee_z) * x,
        )

    def rates(self, velocity: ca.SX) -> ca.SX:
        """Rates [3] rad/s of the joints when the foot moves with a velocity [3] m/s in the base frame."""
        x, across, up = ca.vertsplit(self._in_plane(velocity))
        abduction = across / self._depth
        up -= self._limb.aside * abduction
        knee_x, knee_z = self._knee
        lever_x, lever_z = self._x - knee_x, self._z - knee_z
        spread = self._z * knee_x - self._x * knee_z
        return ca.vertcat(
            abduction,
            (x * lever_x + up * lever_z) / spread,
            (-self._z * up - self._x * x) / spread,
        )

    def inertial_torques(self, acceleration: ca.SX) -> ca.SX:
        """Torques [3] N m that give the leg's own mass an acceleration [3] m/s^2 of the foot, in the base frame.

        With the inertia of the standing pose, and without what the joints' rates alone would ask for.
        """
        abduction, hip, knee = ca.vertsplit(self.rates(acceleration))
        (a, b), (_, c) = self._limb.flexion_inertia
        return ca.vertcat(self._limb.abduction_inertia * abduction, a * hip + b * knee, b * hip + c * knee)

    @property
    def length(self) -> ca.SX:
        """From hip to foot, over thigh and shank together: 1 is a straight knee."""
        return ca.sqrt(self._x**2 + self._z**2) / (self._limb.thigh + self._limb.shank)

    @cached_property
    def _knee(self) -> tuple[ca.SX, ca.SX]:
        """Where the knee is in the plane, by the law of cosines."""
        limb = self._limb
        square = self._x**2 + self._z**2
        along = (square + limb.thigh**2 - limb.shank**2) / (2 * square)
        bend = ca.sqrt(ca.fmax(limb.thigh**2 / square - along**2, STRAIGHTEST**2))
        bend *= 1 if limb.knee == "forward" else -1
        return along * self._x - bend * self._z, along * self._z + bend * self._x

    def _in_plane(self, vector: ca.SX) -> ca.SX:
        """A vector [3] of the base frame along the plane's x, across it, and along its z."""
        return ca.vertcat(
            vector[0],
            self._cos * vector[1] + self._sin * vector[2],
            self._cos * vector[2] - self._sin * vector[1],
        )
