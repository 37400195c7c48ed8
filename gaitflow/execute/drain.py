"""A Dask worker that finishes its unit before it ends at its lifetime.

Dask's own worker moves its data away at its lifetime and closes at once, which would cut off the unit in work.
"""

from __future__ import annotations

import asyncio

from distributed import Status, Worker

POLL_S = 0.2


class DrainingWorker(Worker):
    """Named on the command line of every worker on a cluster (`--worker-class`)."""

    async def close_gracefully(self, restart: bool | None = None, reason: str = "worker-close-gracefully") -> None:
        """Take nothing new, wait for the unit in work, then hand back what was waiting here and close."""
        if self.status == Status.running:
            self.status = Status.paused
            while self.state.executing_count and self.status == Status.paused:
                await asyncio.sleep(POLL_S)
        await super().close_gracefully(restart=restart, reason=reason)
