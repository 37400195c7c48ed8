"""A plan as a planner follows it: one cycle's arrays as a motion at any time. Numpy only.

motion = plan.motion(swing_apex=0.05)
state = motion.at(1.234)
stances = motion.phases("LF", cycles=2)
"""

from gaitflow.motion.frames import FootFrame, Frames
from gaitflow.motion.motion import Motion, Point
from gaitflow.motion.stances import Stance
from gaitflow.motion.state import State

__all__ = ["FootFrame", "Frames", "Motion", "Point", "Stance", "State"]
