"""classifier.onnx: tasks in, probabilities of the gaits out; the scaler of the inputs is part of the graph."""

from __future__ import annotations

from threading import Timer

import numpy as np
import onnxruntime as ort
from numpy.typing import NDArray

from gaitflow.core.errors import ArtifactError
from gaitflow.runtime.onnx_graph import graph_fault
from gaitflow.runtime.strict import shown

OUTPUT = "probability"
SUM = 1e-4  # float32 probabilities of some hundred gaits add up to 1 within this
LIMIT_S = 5.0  # of three tasks, which take microseconds


class Classifier:
    """A loaded graph: one float32 input [N, a], the map's ranged axes in their order, output `probability` [N, G].

    Given as bytes, so that a graph cannot name other files for its weights; only operators that classifiers need are
    run, see `onnx_graph`. Safe to call from many threads. Raises ArtifactError when the graph does not load, has other
    operators, inputs or outputs, or takes long.
    """

    def __init__(self, content: bytes, axes: int, gaits: int, where: str) -> None:
        if fault := graph_fault(content):
            raise ArtifactError(f"{where}: {fault}; copy the map again or publish a new version")
        options = ort.SessionOptions()
        # A query is a few microseconds of work: waking threads costs more than they save.
        options.intra_op_num_threads = 1
        options.inter_op_num_threads = 1
        options.log_severity_level = 4
        try:
            # Folding constants would run nodes here, where nothing limits how long they take.
            self._session = ort.InferenceSession(
                content, options, providers=["CPUExecutionProvider"], disabled_optimizers=["ConstantFolding"]
            )
        except Exception as error:  # onnxruntime's errors share no base class but this one
            raise ArtifactError(f"{where}: onnxruntime cannot load it ({shown(str(error), 300)})") from None
        inputs, outputs = self._session.get_inputs(), {each.name: each.type for each in self._session.get_outputs()}
        if len(inputs) != 1 or inputs[0].type != "tensor(float)" or outputs.get(OUTPUT) != "tensor(float)":
            found = shown(", ".join(outputs), 200)
            raise ArtifactError(f"{where}: expected one float32 input and the output {OUTPUT!r}, found {found}")
        self._input = inputs[0].name
        self._where = where
        for rows in (1, 3):
            answer = self._first_answer(np.ones((rows, axes), dtype=np.float32))
            self._check_shape(answer, (rows, gaits))
            self._check_probabilities(answer)

    def __call__(self, tasks: NDArray[np.float32]) -> NDArray[np.float32]:
        """Probabilities [N, G] of tasks [N, a]. Raises ArtifactError where the answer is none."""
        rows = self._run(tasks)
        self._check_probabilities(rows)
        return rows

    def _check_probabilities(self, rows: NDArray[np.float32]) -> None:
        if len(rows) == 1:  # in Python's own numbers a single task takes a tenth of numpy's time
            row: list[float] = rows[0].tolist()
            sound = min(row) >= 0 and abs(sum(row) - 1) <= SUM
        else:
            sound = bool((rows >= 0).all() and (np.abs(rows.sum(axis=1) - 1) <= SUM).all())
        if not sound:
            raise ArtifactError(
                f"{self._where}: its probabilities are not at least 0 with sum 1 at every task; "
                "copy the map again or publish a new version"
            )

    def _run(self, tasks: NDArray[np.float32], options: ort.RunOptions | None = None) -> NDArray[np.float32]:
        try:
            result: NDArray[np.float32] = self._session.run([OUTPUT], {self._input: tasks}, options)[0]
        except Exception as error:
            raise ArtifactError(f"{self._where}: the classifier failed ({shown(str(error), 300)})") from None
        return result

    def _first_answer(self, tasks: NDArray[np.float32]) -> NDArray[np.float32]:
        """The answer of a graph that may take for ever: after LIMIT_S it is ended."""
        options = ort.RunOptions()
        alarm = Timer(LIMIT_S, setattr, (options, "terminate", True))
        alarm.daemon = True
        alarm.start()
        try:
            return self._run(tasks, options)
        finally:
            alarm.cancel()

    def _check_shape(self, answer: object, shape: tuple[int, int]) -> None:
        if not isinstance(answer, np.ndarray) or answer.shape != shape or not np.isfinite(answer).all():
            found = getattr(answer, "shape", type(answer).__name__)
            raise ArtifactError(f"{self._where}: {OUTPUT} must be finite with shape {shape}, found {found}")
