"""One quantity over a family of steps: its values, its error at each step, and its order.

An event between two steps (plate, bat, ground) can cause an error that jumps with its phase, the
position of the event within the step. To recognise it, the quantity is evaluated again with a step
that is so little shorter that a smooth error stays the same, while the phase changes. A quantity
with jumps is evaluated at several phases of each step, and its error is their root mean square.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from longball.convergence.order import (
    FEWEST,
    PowerLaw,
    errors_without_truth,
    fit_power_law,
    richardson,
    typical,
)
from longball.convergence.report import Level, Limit, Order, OrderVerdict, Use
from longball.model.arrays import Array

Expected = float | Mapping[str, float] | None

EPSILON = float(np.finfo(np.float64).eps)

# Phases of each step for a quantity with jumps. The root mean square of n is known to 1/√(2 n):
# with eight, to a quarter.
PHASES = 8
# Relative change of the error with the phase that counts as a jump, beyond that of a smooth error,
# which is p times the change of log h. Smaller jumps disappear in the allowed curvature of the
# line.
JUMP = 0.15
# Least ratio of two steps whose means over phases are subtracted: closer steps would amplify the
# noise of the means.
FAR = 4.0
# Allowed difference between the observed order and theory, besides the interval of the observed
# order.
TOLERANCE = 0.1
# Orders are integers or halves: a wider 95 % interval does not distinguish neighbouring orders.
UNDECIDED = 0.4


@dataclass(frozen=True)
class Observed:
    """One quantity of all scenes, at one step or in truth."""

    quantity: str
    unit: str
    # (scene, component); NaN if a scene lacks the quantity or has another outcome than expected.
    values: Array


def step_family(steps: Sequence[float]) -> Array:
    """Return the different steps, the coarsest first; raise a ValueError if there are too few."""
    family = np.array(sorted(set(steps), reverse=True), float)
    if len(family) < FEWEST or not (np.isfinite(family).all() and family[-1] > 0):
        raise ValueError(f"{len(family)} steps; {FEWEST} different positive ones are needed")
    return family


def phase_step(step: float, clock: float, phase: int) -> float:
    """Return a slightly shorter step, in which an event at the time `clock` has another phase."""
    # Multiples of the golden ratio, mod 1, are evenly spread for every number of phases.
    share = phase * (math.sqrt(5) - 1) / 2 % 1.0
    return step / (1 + share * step / clock)


def observe(
    evaluate: Callable[[float], Sequence[Observed]],
    family: Array,
    truth: Sequence[Observed] | None,
    *,
    scenes: Sequence[str],
    expected: Expected,
    first: float,
    last: float,
    phases: int,
    progress: Callable[[int, int], None],
) -> tuple[tuple[Order, ...], tuple[Limit, ...]]:
    """Evaluate quantities at a family of descending steps, and fit the order of each."""
    # `evaluate` returns the same quantities at every step. `first` and `last` are the times of the
    # first and the last event of all scenes, s. `phases` is the number of phases of each step for a
    # quantity with jumps; 1 means no search for jumps. `progress` takes the number of evaluations
    # done and their total as known so far.
    wanted = expected.values() if isinstance(expected, Mapping) else [expected or 0.0]
    if not all(map(math.isfinite, wanted)):
        raise ValueError(f"expected = {expected}: an order is a finite number")
    done: dict[tuple[int, int], Sequence[Observed]] = {}

    def measured(count: int) -> list[_Measured]:
        """Evaluate the first `count` phases of every step, except those already evaluated."""
        planned = [(level, phase) for level in range(len(family)) for phase in range(count)]
        steps = np.array([[phase_step(h, first, phase) for phase in range(count)] for h in family])
        for key in planned:
            if key not in done:
                done[key] = evaluate(float(steps[key]))
                progress(len(done), len(planned))
        every = []
        for i, one in enumerate(done[0, 0]):
            flat = np.array([done[key][i].values for key in planned])
            values = flat.reshape(*steps.shape, *one.values.shape).transpose(2, 0, 1, 3).copy()
            true = truth[i].values if truth else None
            every.append(_Measured(one.quantity, one.unit, steps, values, true, last / family))
        return every

    # Two phases show whether a quantity jumps. The others are evaluated only then.
    errors_by_step = measured(min(2, phases))
    jumps = [_jump(one) if phases > 1 else 0.0 for one in errors_by_step]
    if max(jumps, default=0.0) > JUMP:
        errors_by_step = measured(phases)
    orders: list[Order] = []
    limits: list[Limit] = []
    for one, jump in zip(errors_by_step, jumps, strict=True):
        # A quantity that is zero in every scene, such as a sideways landing, has no order.
        if one.size == 0.0:
            continue
        theory = expected.get(one.quantity) if isinstance(expected, Mapping) else expected
        order, law = _assess(one, jump, theory)
        orders.append(order)
        if law is not None:
            limits += _limits(one, jump > JUMP, law, scenes)
    return tuple(orders), tuple(limits)


@dataclass(frozen=True)
class _Measured:
    """One quantity at all steps."""

    quantity: str
    unit: str
    steps: Array  # s, (step, phase)
    values: Array  # (scene, step, phase, component); NaN where there is none
    truth: Array | None  # (scene, component), or None
    counts: Array  # steps up to the last event, (step,)

    @property
    def size(self) -> float:
        """Largest absolute value; 0 if there are none."""
        return float(np.max(np.abs(self.values), where=np.isfinite(self.values), initial=0.0))

    def levels(self, jumps: bool) -> Array:
        """Return each step, or the geometric mean of its phases if the error jumps, s."""
        means: Array = np.exp(np.log(self.steps if jumps else self.steps[:, :1]).mean(axis=1))
        return means

    def means(self, jumps: bool) -> Array:
        """Return the values (scene, step, component), averaged over phases if they jump."""
        return mean_over_phases(self.values if jumps else self.values[:, :, :1])

    def errors(self, jumps: bool, order: float) -> Array:
        """Return the errors (scene, step), root mean squares over phases if they jump.

        `order` is an estimate, needed only without the truth.
        """
        if self.truth is None:
            levels, ratio = self.levels(jumps), FAR if jumps else 1.0
            return np.array(
                [errors_without_truth(levels, values, order, ratio) for values in self.means(jumps)]
            )
        values = self.values if jumps else self.values[:, :, :1]
        off = np.linalg.norm(values - self.truth[:, None, None, :], axis=-1)
        rms: Array = np.sqrt(mean_over_phases(off**2))
        return rms


def mean_over_phases(values: Array) -> Array:
    """Return the mean over the phases, axis 2, at which there is a value; NaN without one."""
    known = np.isfinite(values)
    with np.errstate(invalid="ignore"):
        mean: Array = np.where(known, values, 0.0).sum(axis=2) / known.sum(axis=2)
    return mean


def _jump(one: _Measured) -> float:
    """Return the relative change of the error with the phase.

    It is the median over scenes and the finer half of the steps, minus the change of a smooth error
    from one phase to the next. Errors at the level of rounding are excluded.
    """
    fine = slice(len(one.steps) // 2, None)
    change = np.linalg.norm(one.values[:, fine, 1] - one.values[:, fine, 0], axis=-1)
    error = one.errors(jumps=False, order=1.0)[:, fine]  # a guess: a free choice
    # Independent rounding errors grow with the square root of their number.
    noise = 4 * EPSILON * one.size * np.sqrt(one.counts[fine])  # a free choice above it
    clear = np.isfinite(change) & np.isfinite(error) & (np.maximum(error, change) > noise)
    if not clear.any():
        return 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = change / np.maximum(error, change)
        slopes = np.diff(np.log(error), axis=1) / np.diff(np.log(one.steps[fine, 0]))
    order = max(0.0, float(np.nanmedian(slopes))) if np.isfinite(slopes).any() else 0.0
    smooth = 1.0 - (one.steps[fine, 1] / one.steps[fine, 0]) ** order
    return max(0.0, float(np.median((relative - smooth)[clear])))


def _assess(one: _Measured, jump: float, expected: float | None) -> tuple[Order, PowerLaw | None]:
    """Fit the order of one quantity and compare it with theory."""
    jumps = jump > JUMP
    steps, order = one.levels(jumps), 1.0  # a first guess: a free choice
    # Without the truth the errors depend on the order; three rounds determine it to 1e-3.
    for _ in range(5):
        errors = typical(np.maximum(one.errors(jumps, order), EPSILON / 2 * one.size))
        law = fit_power_law(steps, errors)
        if law is None or one.truth is not None:
            break
        order = law.order
    wide = _widened(law, steps, one.steps.shape[1]) if law and jumps else law
    verdict, why = _verdict(one, errors, steps, law, wide, expected)
    if jumps:
        why += f"; it jumps with the phase of the step, by {100 * jump:.0f} % of the error"
    scenes = np.isfinite(one.errors(jumps, order)).sum(axis=0).tolist()
    phases = one.steps.shape[1] if jumps else 1
    pairs = zip(steps.tolist(), errors.tolist(), scenes, strict=True)
    rungs = tuple(
        Level(step=step, error=None if math.isnan(error) else error, scenes=count, phases=phases,
              use=_use(level, error, law))
        for level, (step, error, count) in enumerate(pairs)
    )  # fmt: skip
    report = Order(
        quantity=one.quantity, unit=one.unit, order=law.order if law else None,
        low=wide.low if wide else None, high=wide.high if wide else None,
        constant=law.constant if law else None, expected=expected, jump=jump,
        jumps=jumps, rungs=rungs, verdict=verdict, why=why,
    )  # fmt: skip
    return report, law


def _use(level: int, error: float, law: PowerLaw | None) -> Use:
    if math.isnan(error) or law is None:
        return "no error" if math.isnan(error) else "no range"
    if level < law.first:
        return "pre-asymptotic"
    return "floor" if level > law.last else "fitted"


def _widened(law: PowerLaw, steps: Array, phases: int) -> PowerLaw:
    """Return a law whose interval includes the noise of means over a few phases."""
    # The relative noise of each mean is 1/√(2 phases); neighbouring steps may have the same error.
    x = np.log(steps[law.first : law.last + 1])
    noise = 1 / math.sqrt(2 * phases * float(((x - x.mean()) ** 2).sum()))
    half = math.hypot(law.half_width, 2 * noise)
    return replace(law, low=law.order - half, high=law.order + half)


def _verdict(
    one: _Measured,
    errors: Array,
    steps: Array,
    law: PowerLaw | None,
    wide: PowerLaw | None,
    expected: float | None,
) -> tuple[OrderVerdict, str]:
    """Return the verdict on one quantity, and its reason; `wide` has the interval to be shown."""
    unit = one.unit
    there = np.flatnonzero(np.isfinite(errors))
    # Worst case of rounding: all errors have the same sign.
    bound = EPSILON * one.size * one.counts
    if len(there) == 0:
        return "not resolved", "no scene has the right outcome at two steps"
    if (errors[there] <= bound[there]).all():
        most = f"{errors[there].max():.1e} {unit}"
        return "exact", f"the typical error is rounding, at most {most}"
    # A wrong limit: the finest error is above rounding, and either far above the fitted line or, if
    # there is no line, within a factor of two of the errors before it.
    finest = there[-1]
    stuck = errors[finest] > bound[finest] and (
        errors[finest] > 3 * law.error(steps[finest])
        if law
        else len(there) >= FEWEST and np.ptp(np.log(errors[there[-FEWEST:]])) < math.log(2)
    )
    if one.truth is not None and stuck:
        return "wrong limit", (
            f"the error stays at {errors[finest]:.2e} {unit}, above rounding "
            f"(at most {bound[finest]:.0e}): the results converge to another value than the truth"
        )
    advice = ""
    if errors[finest] <= bound[finest]:
        advice = "; the errors at the finest steps are rounding: try longer steps, such as "
        advice += f"{5 * steps[0]:.2g} to {steps[0] / 2:.2g} s"
    if law is None or wide is None:
        why = f"no {FEWEST} steps are on one line: there is no asymptotic range"
        return "not resolved", why + advice
    seen = f"order {law.order:.3f} ({wide.low:.3f} to {wide.high:.3f})"
    if expected is not None and abs(law.order - expected) > TOLERANCE + wide.half_width:
        return "other order", f"{seen}, but {expected:g} in theory"
    if law.half_width > UNDECIDED / 2:
        return "not resolved", f"{seen}: the interval is too wide for an order{advice}"
    if expected is None:
        return "no expectation", seen
    return "as expected", f"{seen}, {expected:g} in theory"


def _limits(one: _Measured, jumps: bool, law: PowerLaw, scenes: Sequence[str]) -> list[Limit]:
    """Extrapolate the quantity of every scene, from the finest steps of the asymptotic range."""
    steps, means = one.levels(jumps)[: law.last + 1], one.means(jumps)[:, : law.last + 1]
    limits = []
    for scene, values in enumerate(means):
        if limit := richardson(steps, values, law.order):
            value, error = limit
            off = None if one.truth is None else float(np.linalg.norm(value - one.truth[scene]))
            limits.append(
                Limit(scene=scenes[scene], quantity=one.quantity, value=tuple(value.tolist()),
                      error=error, off=off)
            )  # fmt: skip
    return limits
