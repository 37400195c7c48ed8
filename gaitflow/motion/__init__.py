"""A plan as a planner follows it: one cycle's arrays as a motion at any time. Numpy only.

motion = plan.motion()
state = motion.at(1.234)
stances = motion.phases("LF", cycles=2)
"""

from gaitflow.motion.contact_schedule import schedule_data, schedule_json
from gaitflow.motion.frames import FootFrame, Frames
from gaitflow.motion.journey import Journey
from gaitflow.motion.motion import Motion, Point
from gaitflow.motion.ocs2 import gait_info, mode_schedule
from gaitflow.motion.stances import Stance
from gaitflow.motion.standing import standing
from gaitflow.motion.state import State
from gaitflow.motion.towr import towr_formulation
from gaitflow.motion.transition import Transition

__all__ = [
    "FootFrame", "Frames", "Journey", "Motion", "Point", "Stance", "State", "Transition", "gait_info", "mode_schedule",
    "schedule_data", "schedule_json", "standing", "towr_formulation",
]  # fmt: skip
