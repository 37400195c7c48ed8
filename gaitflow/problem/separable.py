"""A partially separable cost: many copies of a few elements, each a function of a few variables, and a rest.

As one expression, every copy of an element would be derived anew. Here an element is a small function that is derived
once and evaluated for every copy. Its derivatives are added where its variables are (Griewank and Toint, 1982).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from gaitflow.core.task import AXES
from gaitflow.core.trajectory import Array
from gaitflow.problem.copies import Pieces

Expression = Callable[[ca.SX, ca.SX], ca.SX]  # of variables and task [axes]


@dataclass(frozen=True, eq=False)
class Element:
    """The sum over all copies of weights [copies] times `value` of the variables at places [copies, n] of w.

    value: (x [n], task [axes]) -> cost [1]; second: the same -> (gradient [n], upper triangle of the Hessian [n, n]).
    gates [copies] are places of w, too, of numbers that are 0 or 1: where there is 0 no free variable matters to a
    copy, and it is left out of the derivatives.
    """

    value: ca.Function
    second: ca.Function
    places: NDArray[np.intp]
    weights: Array
    gates: NDArray[np.intp] | None = None

    @classmethod
    def chained(
        cls, maps: Sequence[Expression], places: NDArray[np.intp], weights: Array,
        gates: NDArray[np.intp] | None = None,
    ) -> Element:  # fmt: skip
        """The element that is the last of the maps after all others, derived by the chain rule.

        Short maps from fewer and fewer variables to a cost have shorter derivatives than all at once: a third less
        for a leg's power.
        """
        x, task = ca.SX.sym("x", places.shape[1]), ca.SX.sym("task", len(AXES))
        reached = [x]
        for each in maps:
            reached.append(each(reached[-1], task))
        gradient, hessian = ca.SX(1), ca.SX(0)
        for each, point in zip(reversed(maps), reversed(reached[:-1]), strict=True):
            jacobian, bend = _derived(each, point, task, gradient)
            hessian = ca.triu2symm(ca.triu(jacobian.T @ (hessian @ jacobian) + bend))
            gradient = jacobian.T @ gradient
        second = ca.cse([ca.densify(gradient), ca.triu(hessian)])
        return cls(
            ca.Function("value", [x, task], [reached[-1]]),
            ca.Function("second", [x, task], second),
            places,
            weights,
            gates,
        )

    def cost(self, w: ca.SX, task: ca.SX) -> ca.SX:
        """The element's part of the cost."""
        copies = zip(self.places, self.weights, strict=True)
        return sum((float(weight) * self.value(w[list(place)], task) for place, weight in copies), ca.SX(0))


def _derived(step: Expression, point: ca.SX, task: ca.SX, pull: ca.SX) -> tuple[ca.SX, ca.SX]:
    """At a point: the Jacobian of a map, and the Hessian of pull @ map."""
    x, by = ca.SX.sym("x", point.numel()), ca.SX.sym("pull", pull.numel())
    image = step(x, task)
    results = [ca.jacobian(image, x), ca.hessian(ca.dot(by, image), x)[0]]
    jacobian, bend = ca.Function("derived", [x, task, by], ca.cse(results))(point, task, pull)
    return jacobian, bend


@dataclass(frozen=True, eq=False)
class SeparableProblem:
    """A nonlinear program (w [nw], task [axes]) -> (cost [1], rows [ng]): `rest`, and the costs of elements.

    pieces: what `rest` is made of, where that is known.
    """

    rest: ca.Function
    elements: tuple[Element, ...] = ()
    pieces: Pieces | None = None

    @cached_property
    def function(self) -> ca.Function:
        """All of it as one function."""
        if not self.elements:
            return self.rest
        w, task = (ca.SX.sym(name, self.rest.numel_in(i)) for i, name in enumerate(("w", "task")))
        cost, rows = self.rest(w, task)
        for element in self.elements:
            cost += element.cost(w, task)
        return ca.Function("nlp", [w, task], [cost, rows], ["w", "task"], ["cost", "rows"])
