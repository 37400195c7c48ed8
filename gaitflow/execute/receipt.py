"""What a Dask task returns: how its unit ended. Solutions themselves never leave the store."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any, Literal

# solved: stored now. already: another process had stored it. failed: given up after too many attempts, stored so.
# raised: the solver threw (the child's word only, it costs an attempt). refused: the run itself cannot go on.
Outcome = Literal["solved", "already", "failed", "raised", "refused"]


@dataclass(frozen=True)
class Receipt:
    """What became of one unit: `error` says why when it was not solved, `attempts` lists those lost on the way.

    `solves` is how many it took, 0 for one that was not solved now; as many as `known` were done by earlier processes.
    """

    unit: str
    outcome: Outcome
    error: str = ""
    attempts: tuple[str, ...] = ()
    solves: int = 0
    known: int = 0

    def to_line(self) -> str:
        """One line of JSON."""
        return json.dumps(asdict(self)) + "\n"

    @classmethod
    def from_data(cls, data: Any) -> Receipt:
        """Inverse of `to_line`, whose line was read as JSON. Raises ValueError for anything else."""
        try:
            return cls(**{**data, "attempts": tuple(data["attempts"])})
        except (KeyError, TypeError) as error:
            raise ValueError(f"not a receipt: {error}") from None
