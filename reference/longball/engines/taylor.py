"""Taylor's method for `scipy.integrate.solve_ivp`, for any traced law.

    solve_ivp(right_hand_side(law), (0, 60), start, method=Taylor, law=law, dense_output=True)

A step is a Taylor series of high order in time (`longball.engines.expander`). The series itself is
the dense output: a state between two steps, and an event there, is as exact as the steps.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.integrate import DenseOutput, OdeSolver

from longball.engines.expander import ORDER, TRUNCATION, Expander, NoStep, step
from longball.engines.polynomial import values_at
from longball.model.arrays import Array
from longball.model.law import Law
from longball.model.numbers import DOUBLES


def right_hand_side(law: Law[float]) -> Callable[[float, Array], Sequence[float]]:
    """Return the law as `solve_ivp` takes it: a function of time and state."""
    rates = law.rates(DOUBLES)

    def function(_: float, y: Array) -> Sequence[float]:
        return rates(*y.tolist())  # doubles of Python: numpy's are five times slower one by one

    return function


class Taylor(OdeSolver):  # type: ignore[misc]
    """Taylor's method, as a `method` of `solve_ivp`.

    Parameters
    ----------
    fun
        Not called: the law is what is integrated.
    t0, y0, t_bound, vectorized
        As every `OdeSolver` takes them.
    law
        The law of motion, or any other traced law: its `program` has the rates of its variables as
        outputs, its `strengths` the values of the program's parameters.
    order
        Of the series.
    rtol
        Of the last terms of the series, relative to the size of what changes (of the velocity).
    max_step
        s.
    **extraneous
        Options of other methods; a warning names them.
    """

    t: float
    t_bound: float
    direction: float
    n: int
    y: Array
    status: str

    def __init__(
        self,
        fun: Callable[..., Any] | None,
        t0: float,
        y0: Any,
        t_bound: float,
        vectorized: bool = False,
        *,
        law: Law[float],
        order: int = ORDER,
        rtol: float = TRUNCATION,
        max_step: float = math.inf,
        **extraneous: Any,
    ) -> None:
        if extraneous:
            warnings.warn(f"Taylor does not take {', '.join(extraneous)}", stacklevel=3)
        super().__init__(fun, t0, y0, t_bound, vectorized)
        self.direction = float(self.direction)
        self._expand = Expander(law, order, rtol)
        self._max_step = max_step
        self._low = np.zeros(self.n)

    def _step_impl(self) -> tuple[bool, str | None]:
        try:
            self._x, self.t, self.y, self._low = step(
                self._expand,
                self.t,
                self.y,
                self._low,
                self.t_bound,
                self.direction,
                self._max_step,
            )
        except NoStep as reason:
            return False, str(reason)
        return True, None

    def _dense_output_impl(self) -> Callable[[float], Array]:
        return Series(self.t_old, self.t, self._x)


class Series(DenseOutput):  # type: ignore[misc]
    """The dense output of a step: its own polynomial.

    Attributes
    ----------
    coefficients
        Shape (n, order + 2): of the powers of ``t - t_old``, for each component of the state.
    """

    def __init__(self, t_old: float, t: float, coefficients: Array) -> None:
        super().__init__(t_old, t)
        self.coefficients = coefficients

    def __call__(self, t: float | Array) -> Array:
        """Return the state at a time, or at several: shape (n,) or (n, times)."""
        if not isinstance(t, float):
            found: Array = super().__call__(t)
            return found
        return values_at(self.coefficients, t - self.t_old)

    def _call_impl(self, t: Array) -> Array:
        if t.ndim == 0:
            return self(float(t))
        return np.reshape([self(each) for each in t.tolist()], (-1, len(self.coefficients))).T
