"""Programs of robots that take a plan: simulation, whole-body shooting, predictive control."""
