"""classifier.onnx: tasks in, probabilities of the gaits out; the scaler of the inputs is part of the graph."""

from __future__ import annotations

import numpy as np
import onnxruntime as ort
from numpy.typing import NDArray

from gaitflow.core.errors import ArtifactError

OUTPUT = "probability"


class Classifier:
    """A loaded graph: one float32 input [N, a], the map's ranged axes in their order, output `probability` [N, G].

    Given as bytes, so that a graph cannot name other files for its weights. Safe to call from many threads.
    Raises ArtifactError when the graph does not load or has other inputs or outputs.
    """

    def __init__(self, content: bytes, axes: int, gaits: int, where: str) -> None:
        options = ort.SessionOptions()
        # A query is a few microseconds of work: waking threads costs more than they save.
        options.intra_op_num_threads = 1
        options.inter_op_num_threads = 1
        options.log_severity_level = 4
        try:
            self._session = ort.InferenceSession(content, options, providers=["CPUExecutionProvider"])
        except Exception as error:  # onnxruntime's errors share no base class but this one
            raise ArtifactError(f"{where}: onnxruntime cannot load it ({str(error)[:300]})") from None
        inputs, outputs = self._session.get_inputs(), [output.name for output in self._session.get_outputs()]
        if len(inputs) != 1 or inputs[0].type != "tensor(float)" or OUTPUT not in outputs:
            raise ArtifactError(f"{where}: expected one float32 input and the output {OUTPUT!r}, found {outputs}")
        self._input = inputs[0].name
        self._where = where
        for rows in (1, 3):
            self._check_shape(self(np.ones((rows, axes), dtype=np.float32)), (rows, gaits))

    def __call__(self, tasks: NDArray[np.float32]) -> NDArray[np.float32]:
        """Probabilities [N, G] of tasks [N, a]."""
        try:
            result: NDArray[np.float32] = self._session.run([OUTPUT], {self._input: tasks})[0]
        except Exception as error:
            raise ArtifactError(f"{self._where}: the classifier failed ({str(error)[:300]})") from None
        return result

    def _check_shape(self, answer: object, shape: tuple[int, int]) -> None:
        if not isinstance(answer, np.ndarray) or answer.shape != shape or not np.isfinite(answer).all():
            found = getattr(answer, "shape", type(answer).__name__)
            raise ArtifactError(f"{self._where}: {OUTPUT} must be finite with shape {shape}, found {found}")
