"""What the tests let a child process call: work that answers, throws, prints, dies or hangs."""

from __future__ import annotations

import os
import signal
import time
from typing import Any


class Worker:
    def __init__(self, offset: int) -> None:
        self._offset = offset
        self._calls = 0

    def __call__(self, do: str, value: int = 0) -> dict[str, Any]:
        self._calls += 1
        if do == "print":
            os.write(1, b"as a C library does\n")
            print("as Python does")
        if do == "raise":
            raise KeyError("no such gait")
        if do == "burn":
            until = time.process_time() + 0.3
            while time.process_time() < until:
                pass
            os.kill(os.getpid(), signal.SIGSEGV)
        if do == "exit":
            os._exit(3)
        if do == "hang":
            time.sleep(60)
        return {"value": value + self._offset, "calls": self._calls, "threads": os.environ.get("OMP_NUM_THREADS")}
