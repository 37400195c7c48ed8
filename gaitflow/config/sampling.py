"""How the tasks of a map are chosen where they are no grid."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from gaitflow.config.file import Config

Count = Annotated[int, Field(ge=1, le=100_000)]
Share = Annotated[float, Field(gt=0, lt=1)]


class Sampling(Config):
    """Tasks chosen in rounds where the map is least sure, until a certificate says that it is good.

    The certificate: with 95 % confidence at most the share `dearer` of the domain's tasks get a plan more than 1 %
    dearer than the search's best, and at most `infeasible` none.
    """

    seed: Annotated[int, Field(ge=0)] = 0
    start: Count | None = None  # tasks that are spread over the whole box first; null: 16 on two axes, doubled an axis
    each: Count | None = None  # tasks of a round after that; null: half as many
    most: Count = 1000  # tasks of all searches at most, of certificates and of a dataset to begin with as well
    dearer: Share = 0.02
    infeasible: Share = 0.005

    def first(self, axes: int) -> int:
        """Tasks of the first round over so many axes."""
        return 4 * 2**axes if self.start is None else self.start

    def further(self, axes: int) -> int:
        """Tasks of every later round."""
        return max(self.first(axes) // 2, 1) if self.each is None else self.each
