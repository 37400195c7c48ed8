"""One leg of a URDF as a chain of joints with a foot at its end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitflow.urdf.mechanism import Array, Mechanism


@dataclass(frozen=True, eq=False)
class LegChain:
    """A leg's name, its foot's frame and its own joints (base first), in a pose [joints] of the whole robot."""

    mechanism: Mechanism
    name: str
    foot: int
    joints: tuple[int, ...]
    pose: Array

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the leg's own joints."""
        return tuple(self.mechanism.joint_names[joint] for joint in self.joints)

    @property
    def effort(self) -> Array:
        """Effort limits of its own joints [own] N m, inf where the URDF states none."""
        return self.mechanism.effort[list(self.joints)]

    @property
    def velocity(self) -> Array:
        """Velocity limits of its own joints [own] rad/s, inf where the URDF states none."""
        return self.mechanism.velocity[list(self.joints)]

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Position limits of its own joints [own] rad, within half a turn each way."""
        own = list(self.joints)
        return np.maximum(self.mechanism.lower[own], -np.pi), np.minimum(self.mechanism.upper[own], np.pi)

    @property
    def stance(self) -> Array:
        """Its own joints' angles in the pose [own] rad, within the bounds."""
        return np.clip(self.pose[list(self.joints)], *self.bounds)

    @property
    def hip(self) -> int:
        """Which of its own joints reach is measured from: hip flexion, which comes after abduction if there is that."""
        return 1 if len(self.joints) > 2 else 0

    def foot_at(self, own: Array) -> tuple[Array, Array]:
        """Foot [3] m in the base link's frame with its own joints at `own`, and its Jacobian [3, own]."""
        return self._point(self.foot, own)

    def hip_at(self, own: Array) -> tuple[Array, Array]:
        """Hip flexion joint [3] m in the base link's frame with its own joints at `own`, and its Jacobian [3, own]."""
        return self._point(self.mechanism.joint(self.joints[self.hip]), own)

    def _point(self, frame: int, own: Array) -> tuple[Array, Array]:
        angles = self.pose.copy()
        angles[list(self.joints)] = own
        position, jacobian = self.mechanism.point(frame, angles)
        return position, jacobian[:, list(self.joints)]
