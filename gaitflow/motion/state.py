"""The state of a motion at a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array


@dataclass(frozen=True, eq=False)
class State:
    """A motion at a time, or at n times: then every array has a leading axis n. SI units, world frame.

    - time: s.
    - position [d] m, velocity [d] m/s, acceleration [d] m/s^2: of the centre of mass, or of the base link's origin if
      the motion was asked for that.
    - orientation [4]: the unit quaternion (w, x, y, z) that takes vectors of the base frame to the world; its sign does
      not jump from one time to the next. In the plane it turns about -y.
    - angular_velocity [3]: rad/s in the base frame; of a planar robot [1], the pitch rate, nose up.
    - contact [legs]: which feet stand. At the instant of a touchdown the foot stands, at that of a lift-off it swings.
    - feet [legs, d] m, foot_velocities [legs, d] m/s, foot_accelerations [legs, d] m/s^2: of the plan's feet, see
      `Frames`.
    - forces [legs, d]: N, on the robot.
    - until_touchdown [legs]: s until the leg touches down next; for a leg that stands, after its next swing. It is more
      than 0, and inf for a leg that always or never stands.
    """

    time: Array
    position: Array
    velocity: Array
    acceleration: Array
    orientation: Array
    angular_velocity: Array
    contact: NDArray[np.bool_]
    feet: Array
    foot_velocities: Array
    foot_accelerations: Array
    forces: Array
    until_touchdown: Array
