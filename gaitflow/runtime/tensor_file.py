"""Tensors of a safetensors file that nobody has checked yet."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load

from gaitflow.core.errors import ArtifactError
from gaitflow.core.task import AXES
from gaitflow.runtime.strict import LARGEST, shown

MAX_HEADER = 8_000_000  # bytes: of the largest atlas; half a million empty tensors take minutes and gigabytes


@dataclass(frozen=True)
class TensorFile:
    """The tensors by name; `where` is what errors call the file. Every method raises ArtifactError."""

    tensors: Mapping[str, NDArray[Any]]
    where: str

    @classmethod
    def parse(cls, content: bytes, where: str) -> TensorFile:
        """From a file's bytes, whose sizes safetensors checks against each other before anything is made of them."""
        header = int.from_bytes(content[:8], "little")
        if header > MAX_HEADER:
            raise ArtifactError(f"{where}: a header of {header} bytes; it may have at most {MAX_HEADER}")
        try:
            return cls(load(content), where)
        except (SafetensorError, KeyError, ValueError) as error:  # KeyError: an element type numpy does not have
            reason = shown(str(error), 200)
            raise ArtifactError(f"{where}: not a safetensors file ({reason}); copy the map again") from None

    def refuse(self, name: str, fault: str) -> NoReturn:
        """Raise the error of a tensor, or of a part of the file, that has a `fault`."""
        raise ArtifactError(f"{self.where}: {name[:80]} {fault}; copy the map again or publish a new version")

    def expect(self, names: Set[str]) -> None:
        """Refuse a file whose tensors are not exactly these."""
        if odd := sorted(set(self.tensors) ^ names):
            self.refuse(shown(odd[0]), "is missing or too much")

    def length(self, name: str) -> int:
        """Size of a tensor's first dimension."""
        if name not in self.tensors or not self.tensors[name].ndim:
            self.refuse(name, "is missing or has no length")
        return len(self.tensors[name])

    def array(self, name: str, shape: tuple[int, ...], kind: type, finite: bool = True) -> NDArray[Any]:
        """A tensor of this shape and type, read-only, of numbers up to LARGEST; or infinite, unless `finite`."""
        tensor = self.tensors.get(name)
        if tensor is None or tensor.dtype != kind or tensor.shape != shape:
            found = "missing" if tensor is None else f"{tensor.dtype} {tensor.shape}"
            self.refuse(name, f"is {found}; expected {np.dtype(kind)} {shape}")
        sound = np.abs(tensor) <= LARGEST
        if not (sound if finite else sound | np.isinf(tensor)).all():
            self.refuse(name, f"holds a value that is not finite, or beyond {LARGEST:g}")
        tensor.flags.writeable = False
        return tensor

    def names(self, name: str) -> tuple[str, ...]:
        """Names of axes, written in ASCII and joined by commas."""
        size = self.length(name)
        if not 0 < size <= 1000:
            self.refuse(name, f"has {size} bytes; expected 1 to 1000")
        names = tuple(self.array(name, (size,), np.uint8).tobytes().decode("ascii", "replace").split(","))
        if len(set(names)) < len(names) or not set(names) <= set(AXES):
            self.refuse(name, f"are {','.join(names)!r}; this gaitflow knows {', '.join(AXES)}")
        return names
