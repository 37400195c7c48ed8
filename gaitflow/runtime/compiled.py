"""Refining in compiled code: the exported planner of a map as a library that this process calls."""

from __future__ import annotations

import ctypes
import hashlib
import time
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from gaitflow.core.errors import ArtifactError
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.runtime.artifact import Artifact
from gaitflow.runtime.attempt import FAST, NOT_CONVERGED, Attempt, Candidate, Effort, GaitRefiner, Run
from gaitflow.runtime.files import LIMITS, MANIFEST, read_limited
from gaitflow.runtime.refine import Refiner
from gaitflow.solvers.options import CONVERGED

LIBRARY, MAP = "gaitflow_planner.so", "map.bin"
INTERFACE = 1  # of the library's functions
_POINTER, _SIZE = ctypes.c_void_p, ctypes.c_size_t
_NUMBERS = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
_FUNCTIONS: dict[str, tuple[Any, list[Any]]] = {
    "gaitflow_error": (ctypes.c_char_p, []),
    "gaitflow_open": (_POINTER, [ctypes.c_char_p]),
    "gaitflow_close": (None, [_POINTER]),
    "gaitflow_manifest_sha256": (_POINTER, [_POINTER]),
    "gaitflow_new_refiner": (_POINTER, [_POINTER]),
    "gaitflow_delete_refiner": (None, [_POINTER]),
    "gaitflow_refine": (
        ctypes.c_int,
        [_POINTER, _POINTER, _SIZE, ctypes.c_ssize_t, _NUMBERS, _SIZE, _NUMBERS, _NUMBERS, ctypes.POINTER(_SIZE)],
    ),
}


class CompiledMap:
    """The library and the data in the folder where an export of a map was built. For any number of threads."""

    def __init__(self, folder: Path, artifact: Artifact) -> None:
        """Raises ArtifactError where the folder holds no library, or one of another map or version."""
        self._library = _loaded(folder / LIBRARY)
        self._map = self._library.gaitflow_open(str(folder / MAP).encode())
        if not self._map:
            raise ArtifactError(f"{self.error} and build it")
        weakref.finalize(self, self._library.gaitflow_close, self._map)
        manifest = artifact.folder / MANIFEST
        digest = hashlib.sha256(read_limited(manifest, LIMITS[MANIFEST])).digest()
        if ctypes.string_at(self._library.gaitflow_manifest_sha256(self._map), len(digest)) != digest:
            raise ArtifactError(f"{folder}: was built from another map than {artifact.folder}; export that one")

    @property
    def error(self) -> str:
        """What went wrong in this thread's last call that failed."""
        return str(self._library.gaitflow_error().decode(errors="replace"))

    def refiner(self, artifact: Artifact, slow: Callable[[], Refiner]) -> CompiledRefiner:
        """What refines motions in this thread; `slow` does where compiled code cannot. Raises ArtifactError."""
        handle = self._library.gaitflow_new_refiner(self._map)
        if not handle:
            raise ArtifactError(
                f"{artifact.folder}: its compiled planner cannot be used ({self.error}); build it again"
            )
        return CompiledRefiner(self, handle, artifact, slow)

    def finish(self, handle: int) -> None:
        """Give back the memory of a refiner."""
        self._library.gaitflow_delete_refiner(handle)

    def refine(
        self, handle: int, candidate: Candidate, place: Array, effort: Effort, w: Array
    ) -> tuple[bool, float, int]:
        """Write a motion into w [nw]; returns whether it converged, its cost, and the iterations it took."""
        cost, iterations = np.zeros(1), _SIZE()
        sheet = -1 if candidate.sheet is None else candidate.sheet
        arguments = (candidate.gait, sheet, place, effort, w, cost, ctypes.byref(iterations))
        converged = self._library.gaitflow_refine(handle, self._map, *arguments)
        if converged < 0:
            raise ValueError(f"{self.error}")
        return bool(converged), float(cost[0]), iterations.value


class CompiledRefiner(GaitRefiner):
    """Refines as `Refiner` does, in compiled code; its motions are judged by the same check. For one thread."""

    def __init__(self, library: CompiledMap, handle: int, artifact: Artifact, slow: Callable[[], Refiner]) -> None:
        super().__init__(artifact.manifest, artifact.atlas)
        self._library, self._handle, self._slow = library, handle, slow
        weakref.finalize(self, library.finish, handle)

    def fast(self, candidate: Candidate, task: Task, effort: Effort = Effort.FIRST) -> Attempt:
        """As `Refiner.fast`."""
        started = time.perf_counter()
        w = np.zeros(self.manifest.layout.nw)
        converged, cost, iterations = self._library.refine(self._handle, candidate, self.place(task), effort, w)
        status = CONVERGED[0] if converged else NOT_CONVERGED
        attempt = self.judged(Run(candidate, task, started, started, iterations), w, cost, FAST, status)
        # The library believes the problem's own rows. What our check refuses, Python's solver tries from other starts.
        return self._slow().fast(candidate, task, effort) if converged and not attempt.feasible else attempt

    def fallback(self, candidate: Candidate, task: Task) -> Attempt:
        """As `Refiner.fallback`."""
        return self._slow().fallback(candidate, task)


def _loaded(path: Path) -> Any:
    if not path.is_file():
        raise ArtifactError(f"{path}: is not there; build the folder that `gaitflow export MAP --c FOLDER` writes")
    try:
        library = ctypes.CDLL(str(path.resolve()))
        interface = library.gaitflow_interface()
        for name, (result, arguments) in _FUNCTIONS.items():
            function = getattr(library, name)
            function.restype, function.argtypes = result, arguments
    except (OSError, AttributeError) as error:
        raise ArtifactError(
            f"{path}: is no planner of this machine ({error}); export the map again and build it"
        ) from None
    if interface != INTERFACE:
        raise ArtifactError(f"{path}: was exported by another gaitflow; export the map again and build it")
    return library
