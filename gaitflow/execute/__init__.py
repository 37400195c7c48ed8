"""Running units of work on Dask: the store is the truth, Dask only moves work.

`run.py` submits what the store lacks to any Dask cluster; `local.py` makes a cluster of this machine. A worker keeps
one child process that solves (`solver.py`, `solver_process.py`), so that a solver may throw, hang or die.
"""
