"""What a planner imports: load a published gait map, ask which gait a task takes, have it refined.

from gaitflow.runtime import GaitMap

gait_map = GaitMap.load("models/half-cheetah-flat-effort")
choice = gait_map.select(speed=0.9, cycle_duration=0.6)
plan = gait_map.plan(speed=0.9, cycle_duration=0.6)  # needs gaitflow[solve]
state = plan.motion().at(1.234)
"""

from gaitflow.core.errors import ArtifactError, NoTransition, OutOfDomain
from gaitflow.motion import FootFrame, Frames, Journey, Motion, Stance, State, standing
from gaitflow.runtime.choice import Choice, Choices
from gaitflow.runtime.gait_map import GaitMap
from gaitflow.runtime.left_out import ChosenValue
from gaitflow.runtime.plan import Plan
from gaitflow.runtime.tensors import WarmStart

__all__ = [
    "ArtifactError", "Choice", "Choices", "ChosenValue", "FootFrame", "Frames", "GaitMap", "Journey", "Motion",
    "NoTransition", "OutOfDomain", "Plan", "Stance", "State", "WarmStart", "standing",
]  # fmt: skip
