"""Slurm: its jobs, the scripts they run, and the pool of workers made of them."""
