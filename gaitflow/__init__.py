"""gaitflow: learn which gait a legged robot should use, and hand the answer to its planner."""

__version__ = "0.2.0"
