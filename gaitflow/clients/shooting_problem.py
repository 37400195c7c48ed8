"""A motion's contact sequence as Crocoddyl's shooting problem: contacts, swings, the command, friction cones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gaitflow.clients.command import Commanded, commanded
from gaitflow.clients.whole_body import JointMotion, WholeBody
from gaitflow.core.trajectory import Array
from gaitflow.motion import Motion

if TYPE_CHECKING:
    import crocoddyl

# Weights of squared residuals, SI units, integrated over time.
PLACE, TURN, POSTURE = (10.0, 10.0, 100.0), (100.0, 100.0, 100.0), 1.0
SPEED, SPIN, JOINT_SPEED = (50.0, 50.0, 10.0), (1.0, 1.0, 1.0), 0.01
TORQUE, FRICTION, SWING, LANDING_SPEED = 1e-3, 1.0, 1e4, 1e2
CONTACT_GAINS = np.array([0.0, 50.0])  # of a standing foot's position [1/s^2] and velocity [1/s]
CONE_SIDES = 4


@dataclass(frozen=True, eq=False)
class Targets:
    """What the costs of one interval ask for.

    state [nq + nv] is the commanded one; stands, lands [legs]: who stands in the interval, and who has come down at its
    start. feet [legs, 3] m, of swinging feet at its start, of landing ones the foothold.
    """

    state: Array
    stands: NDArray[np.bool_]
    lands: NDArray[np.bool_]
    feet: Array


def import_crocoddyl() -> Any:
    """Crocoddyl. Raises ImportError that says how to get it."""
    try:
        import crocoddyl
    except ImportError as error:
        raise ImportError(f'shooting needs Crocoddyl ({error}): pip install "gaitflow[clients]"') from None
    return crocoddyl


def shooting_problem(body: WholeBody, motion: Motion, path: JointMotion) -> crocoddyl.ShootingProblem:
    """The problem on the times of a path, from its first state; of Crocoddyl's own types, to be changed at will.

    An interval's contacts are those of the motion at its middle, its costs are of the state at its start.
    Raises ValueError as `commanded`; ImportError without Crocoddyl.
    """
    crocoddyl, model = import_crocoddyl(), body.mechanism.model
    state = crocoddyl.StateMultibody(model)
    actuation = crocoddyl.ActuationModelFloatingBase(state)
    targets = _targets(body, motion, path.times)
    steps = np.append(np.diff(path.times), 0.0)
    models = []
    for each, step in zip(targets, steps, strict=True):
        contacts, costs = _contacts(body, state, actuation.nu, each), _costs(body, state, actuation.nu, each)
        for leg in np.flatnonzero(each.stands):
            costs.addCost(f"friction {leg}", _friction(state, body.feet[leg], motion, actuation.nu), FRICTION)
        dynamics = crocoddyl.DifferentialActionModelContactFwdDynamics(state, actuation, contacts, costs, 0.0, True)
        models.append(crocoddyl.IntegratedActionModelEuler(dynamics, step))
    first = np.concatenate([path.configurations[0], path.velocities[0]])
    return crocoddyl.ShootingProblem(first, models[:-1], models[-1])


def _targets(body: WholeBody, motion: Motion, times: Array) -> list[Targets]:
    """Of each interval between times [N + 1] s, and of the last time, with the contacts of the interval before it."""
    at, within = motion.sample(times), motion.sample((times[:-1] + times[1:]) / 2)
    stands = np.vstack([within.contact, within.contact[-1:]])
    lands = np.vstack([np.zeros_like(stands[:1]), stands[1:] & ~stands[:-1]])
    footholds = np.concatenate([within.feet, within.feet[-1:]])
    feet = np.where(lands[..., None], footholds, at.feet)
    states = _states(body, commanded(motion, times))
    return [Targets(*each) for each in zip(states, stands, lands, feet, strict=True)]


def _states(body: WholeBody, wanted: Commanded) -> list[Array]:
    """The standing robot, moved and turned as commanded: configuration and velocity [nq + nv] at each time."""
    states = []
    for position, heading, velocity in zip(wanted.position, wanted.heading, wanted.velocity, strict=True):
        c, s = np.cos(heading), np.sin(heading)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        orientation = np.array([np.cos(heading / 2), 0.0, 0.0, np.sin(heading / 2)])
        origin = position - turn @ np.array(body.frames.com_in_base)
        q = body.configuration(origin, orientation, body.standing)
        rest = np.zeros(len(body.standing))
        states.append(np.concatenate([q, velocity @ turn, [0.0, 0.0, wanted.yaw_rate], rest]))
    return states


def _contacts(body: WholeBody, state: Any, controls: int, targets: Targets) -> Any:
    import pinocchio

    crocoddyl = import_crocoddyl()
    contacts = crocoddyl.ContactModelMultiple(state, controls)
    for leg in np.flatnonzero(targets.stands):
        contact = crocoddyl.ContactModel3D(
            state, body.feet[leg], targets.feet[leg], pinocchio.LOCAL_WORLD_ALIGNED, controls, CONTACT_GAINS
        )
        contacts.addContact(f"foot {leg}", contact)
    return contacts


def _costs(body: WholeBody, state: Any, controls: int, targets: Targets) -> Any:
    """Of the commanded state, of torques, and of feet that swing or have just come down."""
    import pinocchio

    crocoddyl = import_crocoddyl()
    joints, costs = len(body.standing), crocoddyl.CostModelSum(state, controls)
    weights = np.array([*PLACE, *TURN, *[POSTURE] * joints, *SPEED, *SPIN, *[JOINT_SPEED] * joints])
    tracked = crocoddyl.ResidualModelState(state, targets.state, controls)
    costs.addCost(
        "command", crocoddyl.CostModelResidual(state, crocoddyl.ActivationModelWeightedQuad(weights), tracked), 1.0
    )
    torque = crocoddyl.CostModelResidual(state, crocoddyl.ResidualModelControl(state, controls))
    costs.addCost("torque", torque, TORQUE)
    for leg in np.flatnonzero(~targets.stands | targets.lands):
        place = crocoddyl.ResidualModelFrameTranslation(state, body.feet[leg], targets.feet[leg], controls)
        costs.addCost(f"foot {leg}", crocoddyl.CostModelResidual(state, place), SWING)
    for leg in np.flatnonzero(targets.lands):
        rest = crocoddyl.ResidualModelFrameVelocity(
            state, body.feet[leg], pinocchio.Motion.Zero(), pinocchio.LOCAL_WORLD_ALIGNED, controls
        )
        linear = crocoddyl.ActivationModelWeightedQuad(np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]))
        costs.addCost(f"landing {leg}", crocoddyl.CostModelResidual(state, linear, rest), LANDING_SPEED)
    return costs


def _friction(state: Any, foot: int, motion: Motion, controls: int) -> Any:
    """A barrier of the friction pyramid on level ground."""
    crocoddyl = import_crocoddyl()
    cone = crocoddyl.FrictionCone(np.eye(3), motion.task["friction"], CONE_SIDES, True)
    inside = crocoddyl.ActivationModelQuadraticBarrier(crocoddyl.ActivationBounds(cone.lb, cone.ub))
    return crocoddyl.CostModelResidual(
        state, inside, crocoddyl.ResidualModelContactFrictionCone(state, foot, cone, controls)
    )
