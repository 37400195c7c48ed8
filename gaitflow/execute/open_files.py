"""How many workers can be connected: each connection is an open file, and most systems allow a process 1,024."""

from __future__ import annotations

import resource

FILES_PER_WORKER = 4  # three connections were counted; one more while workers come and go
OTHER_FILES = 256


def allow_connections(workers: int) -> str:
    """Raise this process's limit of open files to what a scheduler of so many workers takes.

    Returns "" when it may have so many, else what to tell the user.
    """
    needed = FILES_PER_WORKER * workers + OTHER_FILES
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    allowed = needed if hard == resource.RLIM_INFINITY else min(needed, hard)
    if soft != resource.RLIM_INFINITY and soft < allowed:
        resource.setrlimit(resource.RLIMIT_NOFILE, (allowed, hard))
    if allowed == needed:
        return ""
    most = max(0, allowed - OTHER_FILES) // FILES_PER_WORKER
    return (
        f"the driver may open {hard} files here, {workers} workers take about {needed}: with more than {most} jobs "
        "some cannot connect; lower jobs in the profile, or have the hard limit of open files (ulimit -Hn) raised"
    )
