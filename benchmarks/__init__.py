"""Benchmarks whose results are committed: each module makes one JSON document.

They come with a checkout and are not installed, so the processes that they start find them by PYTHONPATH.
"""

import os
from pathlib import Path

_ROOT = str(Path(__file__).resolve().parents[1])
_SEARCHED = [path for path in os.environ.get("PYTHONPATH", "").split(os.pathsep) if path]
if _ROOT not in _SEARCHED:
    os.environ["PYTHONPATH"] = os.pathsep.join([_ROOT, *_SEARCHED])
