"""Taylor's method for `scipy.integrate.solve_ivp`, for any traced law.

    solve_ivp(right_hand_side(law), (0, 60), start, method=Taylor, law=law, dense_output=True)

A step is a Taylor series of high order in time (Jorba and Zou, *Experimental Mathematics* 14
(2005) 99), from the recurrence that the law implies (`longball.engines.series`). The series itself
is the dense output: a state between two steps, and an event there, is as exact as the steps.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DenseOutput, OdeSolver

from longball.engines.compiled import COMPILES, module_of
from longball.engines.polynomial import advance
from longball.engines.series import recurrence
from longball.model.law import Law
from longball.model.numbers import DOUBLES
from longball.model.trace import Program

Array = NDArray[np.float64]
Rows = Any  # an array of shape (rows, order + 2); of lists where nothing is compiled

# The reach of a series to 16 digits grows like the order, the work like its square. solve_ivp's own
# work for a step is ten times that of a series: of orders from 22 to 42, all above 28 cost the same.
ORDER = 30
# The first terms left out are then smaller than the rounding of the velocity.
TRUNCATION = 2.0**-54


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

    def __init__(
        self,
        fun: Callable[..., Any],
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
        self._expand = Expander(law, order, rtol)
        self._max_step = max_step
        self._low = np.zeros(self.n)

    def _step_impl(self) -> tuple[bool, str | None]:
        left = abs(self.t_bound - self.t)
        self._x, length = self._expand(self.y)
        if not length > 0:
            return False, "the law of motion is beyond the range of double precision"
        if length >= left <= self._max_step:
            t, h = self.t_bound, self.t_bound - self.t
        else:
            h = self.direction * min(length, self._max_step)
            t = self.t + h
            h = t - self.t  # exact, as the two times are close
            if h == 0:
                return False, self.TOO_SMALL_STEP
        end = np.empty(self.n)
        advance(self._x, h, self._low, end)  # the rounding is made up for at the next step
        self.y, self.t = end, t
        return True, None

    def _dense_output_impl(self) -> Series:
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

    def _call_impl(self, t: Array) -> Array:
        if t.ndim:
            return np.column_stack([self._call_impl(each) for each in t])
        state = np.empty(len(self.coefficients))
        advance(self.coefficients, float(t) - self.t_old, np.zeros(len(state)), state)
        return state


# --- a step ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Expander:
    """From states to the series of a law.

    Attributes
    ----------
    law
    order
        Of the series.
    rtol
        Of their last terms; it sets how far they reach.
    """

    law: Law[float]
    order: int = ORDER
    rtol: float = TRUNCATION

    @cached_property
    def _strengths(self) -> list[float]:
        return [self.law.strengths[name] for name in self.law.program.parameters]

    @cached_property
    def _rows(self) -> int:
        return len(recurrence(self.law.program).rows)

    @cached_property
    def _steps(self) -> tuple[Callable[..., float], Callable[..., float]]:
        return _step(self.law.program, False), _step(self.law.program, True)

    def __call__(self, state: Array) -> tuple[Array, float]:
        """Return the coefficients of the components of the state, and how far they reach, s.

        The reach is nan if numbers are beyond the range of doubles.
        """
        step, from_rest = self._steps
        order = self.order
        x, reach = self._expand(step, order, state)
        if not reach > 0 and self._at_rest(x):
            step = from_rest
            x, reach = self._expand(step, order, state)
        # Close to rest coefficients grow like the powers of 1/V, and the last may be too large.
        while not reach > 0 and order > 4:
            order //= 2
            x, reach = self._expand(step, order, state)
        return np.asarray(x[: len(state)]), reach

    def _expand(self, step: Callable[..., float], order: int, state: Array) -> tuple[Rows, float]:
        x: Rows = np.zeros((self._rows, order + 2))
        x[: len(state), 0] = state
        if not COMPILES:
            x = x.tolist()
        try:
            return x, step(x, order, self.rtol, *self._strengths)
        except (ZeroDivisionError, OverflowError):  # compiled code gives inf or nan
            return x, math.nan

    def _at_rest(self, x: Rows) -> bool:
        series = recurrence(self.law.program)
        return any(x[series.rows.index(root)][0] == 0 for root in series.roots)


@cache
def _step(program: Program, at_rest: bool) -> Callable[..., float]:
    """Return the function that expands a series."""
    step: Callable[..., float] = module_of(_source(program, at_rest)).step
    return step


def _source(program: Program, at_rest: bool) -> str:
    """Print ``step(x, order, rtol, *parameters)``, which expands and returns the reach.

    The last two terms of what changes stay below `rtol` times its size, which is that of the first
    term that is not zero. Besides, a square root has to stay analytic: V² ≈ V₀² + S₁ t + S₂ t² has
    its complex zeros near V₀/√S₂ from a place where V is least, and a step stays within half of it.
    """
    series = recurrence(program)
    changing = [i for i, rate in enumerate(program.outputs) if rate.kind != "variable"]

    def total(index: str) -> str:
        return " + ".join(f"abs(x[{i}][{index}])" for i in changing)

    roots = [] if at_rest else [i for i, node in enumerate(series.rows) if node.kind == "sqrt"]
    lines = [
        f"    expand(x, order{''.join(f', {name}' for name in program.parameters)})",
        "    power = 0",
        f"    size = {total('0')}",
        "    if size == 0.0:",
        "        power = 1",
        f"        size = {total('1')}",
        "    reach = inf",
        "    for n in (order - 1, order):",
        f"        last = {total('n')}",
        "        if not last < inf:",
        "            return nan",
        "        if last > 0.0:",
        "            reach = min(reach, (rtol * size / last) ** (1.0 / (n - power)))",
    ]
    for i in roots:
        lines += [
            f"    bend = x[{i}][1] * x[{i}][1] + 2.0 * x[{i}][0] * x[{i}][2]",
            "    if bend != 0.0:",
            f"        reach = min(reach, 0.5 * x[{i}][0] / sqrt(abs(bend)))",
        ]
    return "\n".join(
        [
            "from math import exp, inf, log, nan, sqrt",
            "",
            "from longball.engines.compiled import compiled",
            "",
            "",
            "@compiled",
            series.source(at_rest),
            "",
            "@compiled",
            f"def step({', '.join(('x', 'order', 'rtol', *program.parameters))}):",
            *lines,
            "    return reach",
            "",
        ]
    )
