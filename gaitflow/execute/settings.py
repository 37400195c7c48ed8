"""How Dask is set up: in the driver, and in workers, which inherit it or are told by their environment."""

from __future__ import annotations

import shlex
from typing import Any

from gaitflow.store.lost_workers import MAX_LOST_WORKERS

# Both sides. By itself Dask looks at its own health up to a hundred times a second, in every process: that takes 7 %
# of a core with two workers, on cores that the solvers need; so it takes 2 %.
PROCESS: dict[str, Any] = {
    "distributed.worker.http.routes": [],  # nothing is served over HTTP
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.admin.system-monitor.gil.enabled": False,
}
SETTINGS: dict[str, Any] = PROCESS | {
    # A worker's death is no unit's fault. After so many of them the run asks the journal, which outlives the scheduler.
    "distributed.scheduler.allowed-failures": MAX_LOST_WORKERS - 1,
    "distributed.scheduler.http.routes": [],
    "distributed.scheduler.active-memory-manager.start": False,  # receipts are small
    "distributed.admin.tick.limit": "30s",
    # Nannies and the pool replace lost workers themselves, at once. By itself Dask would close the nanny of a worker
    # that is just being started again when it looks, 15 s after a loss, and never open another.
    "distributed.deploy.lost-worker-timeout": "1 day",
}
CLUSTER_SETTINGS: dict[str, Any] = SETTINGS | {
    "distributed.scheduler.worker-ttl": "2 minutes",  # a node without power says no goodbye
}


def exports() -> str:
    """Lines of a shell script that set up a worker's process."""
    return "\n".join(f"export {_variable(name)}={shlex.quote(str(value))}" for name, value in PROCESS.items())


def _variable(name: str) -> str:
    return "DASK_" + name.replace("-", "_").replace(".", "__").upper()
