"""Schedulers of clusters: what is asked of one (`base`), each of them, the jobs of a run, the pool of workers."""
