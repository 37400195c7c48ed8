"""Solving one gait at one task: the interior-point method of the runtime, and IPOPT."""
