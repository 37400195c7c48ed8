"""A child for the tests of `gaitflow.execute.line_process`: does what it is asked to."""

from __future__ import annotations

import json
import os
import sys
import time
from typing import Any

from gaitflow.execute.line_process import serve


def answer(request: dict[str, Any]) -> str:
    match request["do"]:
        case "say":
            print(request["text"])
            os.write(1, b"and from C\n")
        case "kill":
            os.kill(os.getpid(), request["signal"])
        case "exit":
            print("a last word", file=sys.stderr)
            os._exit(request["code"])
        case "sleep":
            time.sleep(request["seconds"])
    return json.dumps({"threads": os.environ["OMP_NUM_THREADS"], "session": os.getsid(0), "padding": "x" * 200_000})


if __name__ == "__main__":
    serve(int(sys.argv[2]), answer)
