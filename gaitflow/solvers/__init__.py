"""Solving one gait at one task, offline and online: an interior-point method, and IPOPT behind it."""
