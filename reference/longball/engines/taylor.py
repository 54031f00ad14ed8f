"""Taylor's method for `scipy.integrate.solve_ivp`, for any traced law.

    solve_ivp(right_hand_side(law), (0, 60), start, method=Taylor, law=law, dense_output=True)

A step is a Taylor series of high order in time (Jorba and Zou, *Experimental Mathematics* 14
(2005) 99), from the recurrence of the law (`longball.engines.series`). The series is the dense
output, so that states and events between two steps are as accurate as the steps. solve_ivp's
overhead for a step takes five times as long as a series. A step may therefore consist of several
series: with the events as an option, the solver continues until one of them changes its sign.
"""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import DenseOutput, OdeSolver

from longball.engines import reach
from longball.engines.compiled import BEYOND, Code
from longball.engines.polynomial import advanced, values_at
from longball.engines.series import recurrence, row_of
from longball.model.arrays import Array
from longball.model.law import Law
from longball.model.numbers import DOUBLES
from longball.model.trace import Program, squares

Rows = Any  # an array of shape (rows, order + 2); of lists where nothing is compiled

# The reach of a series to 16 digits grows like the order, the work like its square. But the rest of
# a step takes ten times as long as a series: orders from 38 to 46 cost the same.
ORDER = 40  # a free choice
# The first terms left out are then smaller than the rounding of the velocity.
TRUNCATION = 2.0**-54  # a free choice
# From a speed of 1e-300 m/s steps grow by half each, until a thousand later they can be seen.
_MOST_SHORT_STEPS = 5_000  # a free choice


def right_hand_side(law: Law) -> Callable[[float, Array], Sequence[float]]:
    """Return the law as `solve_ivp` takes it.

    Parameters
    ----------
    law
        Of n variables; see `longball.model.law.law_of`.

    Returns
    -------
    callable
        From the time, s, and the state, array of shape (n,), to its n rates of change.

    Examples
    --------
    A ball that only gravity acts on falls 4.9 m in its first second:

    >>> from scipy.integrate import solve_ivp
    >>> from longball.model.law import law_with
    >>> law = law_with({"gravity": 9.8})
    >>> law.variables
    ('s', 'z', 'u', 'w')
    >>> start = [0.0, 10.0, 30.0, 0.0]  # m, m, m/s, m/s
    >>> flown = solve_ivp(right_hand_side(law), (0.0, 1.0), start, method=Taylor, law=law)
    >>> flown.y[:, -1].round(12).tolist()
    [30.0, 5.1, 30.0, -9.8]
    """
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
        Of a series, s.
    until
        The events, as solve_ivp takes them: a step is a series, and the next ones while all of
        these keep their signs.
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
        law: Law,
        order: int = ORDER,
        rtol: float = TRUNCATION,
        max_step: float = math.inf,
        until: Sequence[Callable[[float, Array], float]] = (),
        **extraneous: Any,
    ) -> None:
        if extraneous:
            warnings.warn(f"Taylor does not take {', '.join(extraneous)}", stacklevel=3)
        super().__init__(fun, t0, y0, t_bound, vectorized)
        self.direction = float(self.direction)
        self._law, self._order, self._rtol = law, order, rtol
        self._max_step, self._until = max_step, until
        self._low = np.zeros(self.n)

    def _step_impl(self) -> tuple[bool, str | None]:
        self._parts: list[tuple[float, float, Array]] = []
        after = [event(self.t, self.y) for event in self._until]
        waited, short = 0.0, 0
        while short < _MOST_SHORT_STEPS:
            x, length = expand(self._law, self.y, self._order, self._rtol)
            if not length > 0:  # the next step fails, too, if this one has a series
                return bool(self._parts), "the rates are beyond the range of double precision"
            length = min(length, self._max_step)
            begin, t = self.t, self.t + (waited + self.direction * length)
            if length >= abs(self.t_bound - begin):
                t = self.t_bound
            if t == begin:
                # Close to rest, a series is shorter than the spacing of times: the state moves on,
                # and the time is `waited` for until it shows.
                self.y, self._low = advanced(x, self.direction * length, self._low)
                waited, short = waited + self.direction * length, short + 1
                continue
            # The difference of two times that are close is exact. The next step compensates for the
            # rounding of the state.
            self.y, self._low = advanced(x, t - begin - waited, self._low)
            self.t, waited, short = t, 0.0, 0
            self._parts.append((begin, t, x))
            before, after = after, [event(t, self.y) for event in self._until]
            same = all(a * b > 0 for a, b in zip(before, after, strict=True))
            if not (self._until and same) or t == self.t_bound:
                return True, None
        return bool(self._parts), self.TOO_SMALL_STEP

    def _dense_output_impl(self) -> Callable[[float], Array]:
        return Series(self._parts, self.t)


class Series(DenseOutput):  # type: ignore[misc]
    """The dense output of a step: its series.

    Attributes
    ----------
    parts
        When each begins and ends, and its coefficients, of shape (n, order + 2): of the powers of
        the time since it begins, for each component of the state.
    """

    def __init__(self, parts: list[tuple[float, float, Array]], t: float) -> None:
        super().__init__(parts[0][0], t)
        self.parts = parts
        self._sense = 1.0 if t > self.t_old else -1.0

    def __call__(self, t: Any) -> Array:
        """Return the state at a time, shape (n,), or the states at several, shape (n, times)."""
        if not isinstance(t, float):
            at: Array = super().__call__(t)
            return at
        number = len(self.parts) - 1
        while number > 0 and self._sense * (t - self.parts[number][0]) < 0:
            number -= 1
        begin, _, coefficients = self.parts[number]
        return values_at(coefficients, t - begin)

    def _call_impl(self, t: Array) -> Array:
        return np.reshape([self(float(time)) for time in t.flat], (*t.shape, -1)).T


# --- a step ---------------------------------------------------------------------------------------


def expand(
    law: Law, state: Array, order: int = ORDER, rtol: float = TRUNCATION
) -> tuple[Array, float]:
    """Expand a state into a series of a law.

    Return the coefficients of the components of the state, and how far they reach, s, which `rtol`
    of the last terms decides. The reach is NaN if numbers exceed the range of doubles.
    """
    series, at_rest = recurrence(law.program), False
    strengths = [law.strengths[name] for name in law.program.parameters]
    while True:
        run = _printed(law.program, at_rest).count()
        x: Rows = np.zeros((len(series.rows), order + 2))
        x[: len(state), 0] = state
        x = run.taken(x)
        try:
            length: float = run.step(x, order, rtol, *strengths)
        except BEYOND:
            length = math.nan
        if at_rest and all(row[1] == 0 for row in x[: len(state)]):
            return np.column_stack([state, np.zeros(len(state))]), math.inf  # nothing moves
        if length > 0:
            break
        # From rest, the recurrence of a root divides by V_0 = 0: take the other one. Close to rest
        # coefficients grow like the powers of 1/V, and the last may be too large: take fewer.
        if not at_rest and any(x[series.rows.index(root)][0] == 0 for root in series.roots):
            at_rest = True
        elif order > 4:
            order //= 2
        else:
            break
    return np.asarray(x[: len(state)]), length


# A series takes 0.1 to 1 ms as it is; numba takes half a second to load, and seconds to compile.
_ENOUGH = 2_000  # a free choice


# Names in printed code.
_TAKEN = re.compile(
    "[hjkmnx]|[crsy][0-9]+|exp|expand|log|min|order|range|rtol|sqrt|reach_of_(crisis|root|terms)"
)


@cache
def _printed(program: Program, at_rest: bool) -> Code:
    """Print ``step(x, order, rtol, *parameters)``, which expands and returns the reach."""
    for name in (*program.variables, *program.parameters):
        if _TAKEN.fullmatch(name):
            raise ValueError(f"a variable or parameter of a law cannot be called {name}")
    series = recurrence(program)
    # The position follows from the velocity: only what forces change sets the length of a step.
    changing = [i for i, rate in enumerate(program.outputs) if rate.kind != "variable"]
    changing = changing or list(range(len(program.outputs)))
    lines = [
        f"def step({', '.join(('x', 'order', 'rtol', *program.parameters))}):",
        f"    expand({', '.join(('x', 'order', *program.parameters))})",
        f"    h = reach_of_terms(x, order, rtol, {tuple(changing)})",
    ]
    for i, root in enumerate(series.rows):
        if root.kind != "sqrt":
            continue
        parts = tuple(series.rows.index(row_of(p)) for p in squares(root.args[0]) if not p.static)
        moving = f"if x[{i}][0] != 0.0: " if at_rest else ""
        lines.append(f"    {moving}h = reach_of_root(h, x, {i}, {parts or None})")
    for exponent in series.crises:
        # The row of x + constant would be that of x.
        if row_of(exponent) is exponent:
            i = series.rows.index(exponent)
            lines.append(f"    h = reach_of_crisis(h, x, {i}, order)")
    steps = Path(reach.__file__).read_text("utf-8")
    imports = "from math import exp, log\n\n"
    return Code(
        "\n".join([steps, imports, series.source(at_rest), *lines, "    return h\n"]), _ENOUGH
    )
