"""What everybody shares, numpy only: gaits, names, trajectories, tasks and the independent check."""
