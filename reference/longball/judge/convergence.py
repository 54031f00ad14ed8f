"""What a family of time steps tells about an implementation: the study behind `longball converge`.

Every scene is solved with every step of a ladder. For each quantity of the results the observed
order comes from the steps in its asymptotic range, which `longball.judge.order` finds; the others
are shown with the reason why they are left out. With the truth at hand the errors are those against
it; without, those that the differences of neighbouring steps imply.

An event between two steps (a plate, a bat, the ground) can make an error that jumps with the phase
of the step. It is recognised by solving again with steps so little shorter that a smooth error
would not notice, though the phase is another one. Such a quantity is solved with several phases
at each rung of the ladder, and its error is their root mean square.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from longball.judge.convergence_report import (
    ConvergenceReport,
    Limit,
    Lost,
    Order,
    Rung,
    Use,
    Verdict,
)
from longball.judge.order import (
    FEWEST,
    PowerLaw,
    errors_without_truth,
    fit_power_law,
    richardson,
    typical,
)
from longball.model.result import Bounded, Number, Result
from longball.model.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
Run = Callable[[float], Sequence[Result]]

EPSILON = float(np.finfo(np.float64).eps)

# Phases at each rung for a quantity that jumps: the root mean square of eight is within a quarter.
PHASES = 8
# A smooth error changes by p times the change of log h; this much more is a jump, and below it a
# jump is lost in what is allowed to bend a line.
JUMP = 0.15
# Means over phases keep some noise; their differences are taken between steps so far apart that it
# is not blown up.
FAR = 4.0
# An order is held to theory with this tolerance, besides its own interval.
TOLERANCE = 0.1
# An interval wider than this does not tell an order from the next.
UNDECIDED = 0.4


# --- what is measured -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Quantity:
    """Something that results have in common: its name, its unit, and how to take it from one."""

    name: str
    unit: str
    take: Callable[[Result], Sequence[Number] | None]

    def of(self, result: Result) -> tuple[float, ...] | None:
        """Return its components as doubles; None if the result does not have it."""
        values = self.take(result)
        return None if values is None else tuple(map(_double, values))


def _double(number: Number) -> float:
    return float(number.value) if isinstance(number, Bounded) else number


def _plate_height(result: Result) -> Sequence[Number] | None:
    return (result.plate.position[2],) if result.plate else None


def _contact_time(result: Result) -> Sequence[Number] | None:
    time = result.contact.time if result.contact else None
    return None if time is None else (time,)


QUANTITIES = (
    Quantity("plate height", "m", _plate_height),
    Quantity("contact time", "s", _contact_time),
    Quantity("contact point", "m", lambda r: r.contact.position if r.contact else None),
    Quantity("exit velocity", "m/s", lambda r: r.impact.velocity if r.impact else None),
    Quantity("landing time", "s", lambda r: (r.landing.time,) if r.landing else None),
    Quantity("landing point", "m", lambda r: r.landing.position if r.landing else None),
    Quantity("distance", "m", lambda r: (r.landing.distance,) if r.landing else None),
)


# --- the study ------------------------------------------------------------------------------------


def converge(
    run: Run,
    scenes: Sequence[Scene],
    steps: Sequence[float],
    truth: Sequence[Result] | None = None,
    expected: float | Mapping[str, float] | None = None,
    *,
    phases: int = PHASES,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> ConvergenceReport:
    """Run an implementation with a ladder of steps, and say how it converges.

    Parameters
    ----------
    run
        Solves all the scenes with a step, s; the results carry the scenes' ids.
    scenes
        What is solved; at least one.
    steps
        s; at least five different ones. Their ratio is free.
    truth
        Results of the scenes; without it the finest step says how each scene should end.
    expected
        The order in theory: one for all, or one for each name of `QUANTITIES`.
    phases
        At each rung, of a quantity that jumps with the phase of the step.
    progress
        Called with the runs done, and how many there are so far as is known.

    Raises
    ------
    ValueError
        If there are too few steps, no scenes, or results that belong to no scene.
    """
    if not scenes:
        raise ValueError("there is no scene to converge in")
    ladder = np.array(sorted(set(steps), reverse=True))
    if len(ladder) < FEWEST or not (np.isfinite(ladder).all() and ladder[-1] > 0):
        raise ValueError(f"{len(ladder)} steps; {FEWEST} different positive ones are needed")
    ids = [scene.id for scene in scenes]
    finest = _in_order(run(float(ladder[-1])), ids)
    should = _in_order(truth, ids) if truth is not None else finest
    clock, last = _first_and_last_event(should)
    runs = {(len(ladder) - 1, 0): finest}

    def complete(count: int) -> None:
        """Run what is missing of the first `count` phases of every rung."""
        planned = [(rung, phase) for rung in range(len(ladder)) for phase in range(count)]
        for rung, phase in planned:
            if (rung, phase) not in runs:
                results = run(phase_step(float(ladder[rung]), clock, phase))
                runs[rung, phase] = _in_order(results, ids)
                progress(len(runs), len(planned))

    def measured() -> list[_Measured]:
        return [_measure(q, ladder, clock, last, runs, should, truth) for q in QUANTITIES]

    complete(2)
    found = measured()
    jumps = [_jump(one) for one in found]
    if max(jumps) > JUMP:
        complete(phases)
        found = measured()
    orders: list[Order] = []
    limits: list[Limit] = []
    for one, jump in zip(found, jumps, strict=True):
        if one.size == 0.0:
            continue
        name = one.quantity.name
        wanted = expected.get(name) if isinstance(expected, Mapping) else expected
        order, law = _judge(one, jump, wanted)
        orders.append(order)
        if law is not None:
            limits += _limits(one, jump > JUMP, law, ids)
    lost = (
        Lost(step=float(step), lost=sum(map(_differ, runs[rung, 0], should)), of=len(ids))
        for rung, step in enumerate(ladder)
    )
    return ConvergenceReport(
        engine=finest[0].engine,
        against_truth=truth is not None,
        orders=tuple(orders),
        limits=tuple(limits),
        lost=tuple(lost),
    )


def phase_step(step: float, clock: float, phase: int) -> float:
    """Return a step a little shorter, so that an event at `clock` has another phase in it.

    The phases are multiples of the golden ratio's: well spread, however many there are, and for
    events at other times too.
    """
    share = phase * (math.sqrt(5) - 1) / 2 % 1.0
    return step / (1 + share * step / clock)


def _first_and_last_event(results: Sequence[Result]) -> tuple[float, float]:
    """Return when the first and the last thing happens in any scene, s; 1 s if nothing does."""
    parts = [part for r in results for part in (r.plate, r.contact, r.landing)]
    times = [_double(part.time) for part in parts if part is not None and part.time is not None]
    later = [time for time in times if time > 0] or [1.0]
    return min(later), max(later)


def _in_order(results: Sequence[Result], ids: Sequence[str]) -> list[Result]:
    """Return the results in the order of the scenes; an error for one that is missing."""
    by_id = {result.id: result for result in results}
    strangers = [name for name in by_id if name not in ids]
    if strangers:
        raise ValueError(f"a result belongs to no scene: its id is {strangers[0]!r}")
    return [by_id.get(name) or Result(id=name, error="there is no result") for name in ids]


def _differ(result: Result, should: Result) -> bool:
    return result.outcome != should.outcome


# --- one quantity ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Measured:
    """One quantity of all runs.

    Attributes
    ----------
    steps
        s, (rung, phase).
    values
        (scene, rung, phase, component); NaN where a scene ended otherwise than it should.
    truth
        (scene, component), or None.
    size
        The largest of the values; 0 if there is none.
    counts
        Steps up to the last event, (rung,).
    """

    quantity: Quantity
    steps: Array
    values: Array
    truth: Array | None
    size: float
    counts: Array

    def rungs(self, jumps: bool) -> Array:
        """Return the step that each rung stands for: the phases' geometric mean, s."""
        means: Array = np.exp(np.log(self.steps if jumps else self.steps[:, :1]).mean(axis=1))
        return means

    def means(self, jumps: bool) -> Array:
        """Return the values (scene, rung, component), averaged over phases if they jump."""
        values = self.values if jumps else self.values[:, :, :1]
        known = np.isfinite(values)
        with np.errstate(invalid="ignore"):
            averages: Array = np.where(known, values, 0.0).sum(axis=2) / known.sum(axis=2)
        return averages

    def errors(self, jumps: bool, order: float) -> Array:
        """Return the errors (scene, rung), root mean squares over phases if they jump.

        `order` is a guess, which is needed only without the truth.
        """
        if self.truth is None:
            rungs, ratio = self.rungs(jumps), FAR if jumps else 1.0
            return np.array(
                [errors_without_truth(rungs, values, order, ratio) for values in self.means(jumps)]
            )
        values = self.values if jumps else self.values[:, :, :1]
        off = np.linalg.norm(values - self.truth[:, None, None, :], axis=-1)
        known = np.isfinite(off)
        with np.errstate(invalid="ignore"):
            squares = np.where(known, off, 0.0) ** 2
            rms: Array = np.sqrt(squares.sum(axis=2) / known.sum(axis=2))
        return rms


def _measure(
    quantity: Quantity,
    ladder: Array,
    clock: float,
    last: float,
    runs: Mapping[tuple[int, int], Sequence[Result]],
    should: Sequence[Result],
    truth: Sequence[Result] | None,
) -> _Measured:
    """Take a quantity from all results that end as they should."""
    phases = 1 + max(phase for _, phase in runs)
    right = [quantity.of(result) for result in should]
    width = max((len(value) for value in right if value is not None), default=1)
    values = np.full((len(should), len(ladder), phases, width), np.nan)
    for (rung, phase), results in runs.items():
        for scene, (result, end) in enumerate(zip(results, should, strict=True)):
            value = quantity.of(result)
            if value is not None and right[scene] is not None and not _differ(result, end):
                values[scene, rung, phase] = value
    return _Measured(
        quantity,
        np.array([[phase_step(h, clock, phase) for phase in range(phases)] for h in ladder]),
        values,
        None if truth is None else np.array([value or (np.nan,) * width for value in right]),
        float(np.max(np.abs(values), where=np.isfinite(values), initial=0.0)),
        last / ladder,
    )


def _jump(one: _Measured) -> float:
    """Return how much the error changes with the phase, relative to itself.

    The median over scenes and the finer half of the rungs: there a smooth error hardly changes
    from one phase to the next. Not where rounding rules.
    """
    fine = slice(len(one.steps) // 2, None)
    change = np.linalg.norm(one.values[:, fine, 1] - one.values[:, fine, 0], axis=-1)
    error = one.errors(jumps=False, order=1.0)[:, fine]
    # Independent roundings add up like the square root of their number.
    noise = 4 * EPSILON * one.size * np.sqrt(one.counts[fine])
    clear = np.isfinite(change) & np.isfinite(error) & (np.maximum(error, change) > noise)
    with np.errstate(divide="ignore"):
        relative = change[clear] / np.maximum(error[clear], change[clear])
    return float(np.median(relative)) if clear.any() else 0.0


def _judge(one: _Measured, jump: float, expected: float | None) -> tuple[Order, PowerLaw | None]:
    """Fit the order of one quantity and hold it against theory."""
    jumps = jump > JUMP
    steps, order = one.rungs(jumps), 1.0
    for _ in range(5):  # the guess is needed without the truth; it settles to 1e-3 in three rounds
        errors = typical(np.maximum(one.errors(jumps, order), EPSILON / 2 * one.size))
        law = fit_power_law(steps, errors)
        if law is None or one.truth is not None:
            break
        order = law.order
    verdict, why = _verdict(one, errors, steps, law, expected)
    if jumps:
        why += f"; it jumps with the phase of the step, by {100 * jump:.0f} % of the error"
    known = np.isfinite(one.errors(jumps, order))
    report = Order(
        quantity=one.quantity.name,
        unit=one.quantity.unit,
        order=law and law.order,
        low=law and law.low,
        high=law and law.high,
        constant=law and law.constant,
        expected=expected,
        jump=jump,
        jumps=jumps,
        rungs=tuple(
            Rung(
                step=float(step),
                error=None if math.isnan(error) else float(error),
                scenes=int(known[:, rung].sum()),
                phases=one.steps.shape[1] if jumps else 1,
                use=_use(rung, error, law),
            )
            for rung, (step, error) in enumerate(zip(steps, errors, strict=True))
        ),
        verdict=verdict,
        why=why,
    )
    return report, law


def _use(rung: int, error: float, law: PowerLaw | None) -> Use:
    if math.isnan(error) or law is None:
        return "no error" if math.isnan(error) else "no range"
    if rung < law.first:
        return "pre-asymptotic"
    return "floor" if rung > law.last else "fitted"


def _verdict(
    one: _Measured, errors: Array, steps: Array, law: PowerLaw | None, expected: float | None
) -> tuple[Verdict, str]:
    """Return the verdict on one quantity, and a sentence with its reason."""
    unit = one.quantity.unit
    there = np.flatnonzero(np.isfinite(errors))
    bound = EPSILON * one.size * one.counts  # as many roundings, if all go the same way
    if len(there) == 0:
        return "not resolved", "no scene ends as it should at two steps"
    if (errors[there] <= bound[there]).all():
        return "exact", f"no error above rounding, at most {errors[there].max():.1e} {unit}"
    finest = there[-1]
    stuck = errors[finest] > bound[finest] and (
        errors[finest] > 3 * law.error(steps[finest])
        if law
        else len(there) >= FEWEST and np.ptp(np.log(errors[there[-FEWEST:]])) < math.log(2)
    )
    if one.truth is not None and stuck:
        return "wrong limit", (
            f"the error stays at {errors[finest]:.2e} {unit}, which rounding does not explain "
            f"(at most {bound[finest]:.0e}): the limit is not the truth"
        )
    if law is None:
        return "not resolved", f"no {FEWEST} steps lie on one line: there is no asymptotic range"
    seen = f"order {law.order:.3f} ({law.low:.3f} to {law.high:.3f})"
    if law.half_width > UNDECIDED / 2:
        return "not resolved", f"{seen} does not tell an order from the next"
    if expected is None:
        return "no expectation", seen
    if abs(law.order - expected) <= TOLERANCE + law.half_width:
        return "as expected", f"{seen}, {expected:g} in theory"
    return "other order", f"{seen}, but {expected:g} in theory"


def _limits(one: _Measured, jumps: bool, law: PowerLaw, ids: Sequence[str]) -> list[Limit]:
    """Extrapolate the quantity of every scene, from the finest steps of the asymptotic range."""
    steps, means = one.rungs(jumps)[: law.last + 1], one.means(jumps)[:, : law.last + 1]
    limits = []
    for scene, values in enumerate(means):
        found = richardson(steps, values, law.order)
        if found is None:
            continue
        value, error = found
        off = None if one.truth is None else float(np.linalg.norm(value - one.truth[scene]))
        limits.append(
            Limit(
                scene=ids[scene],
                quantity=one.quantity.name,
                value=tuple(value.tolist()),
                error=error,
                off=off,
            )
        )
    return limits


# --- the picture ----------------------------------------------------------------------------------


def draw_convergence(axes: Axes, report: ConvergenceReport) -> None:
    """Draw error against step for every quantity: fitted steps filled, the others hollow."""
    for order, marker in zip(report.orders, "osD^v<>", strict=False):
        shown = [(r.step, r.error) for r in order.rungs if r.error is not None]
        fitted = [
            (r.step, r.error) for r in order.rungs if r.error is not None and r.use == "fitted"
        ]
        label = order.quantity
        if order.order is not None and order.constant is not None:
            label += f", order {order.order:.2f}"
            line = [order.constant * step**order.order for step, _ in fitted]
            axes.plot([step for step, _ in fitted], line, "-", color="0.6", linewidth=1, zorder=1)
        steps, errors = _columns(shown)
        (drawn,) = axes.plot(steps, errors, marker, markersize=5, markerfacecolor="none")
        steps, errors = _columns(fitted)
        axes.plot(steps, errors, marker, markersize=5, color=drawn.get_color(), label=label)
    axes.set(xscale="log", yscale="log", xlabel="step, s", ylabel="error, SI units")
    axes.legend(fontsize="small", frameon=False)


def _columns(points: Sequence[tuple[float, float]]) -> tuple[list[float], list[float]]:
    return [x for x, _ in points], [y for _, y in points]


def save_convergence(path: Path, report: ConvergenceReport) -> None:
    """Write the picture of a report to a file, in the format that its ending names."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 4.8), layout="constrained")
    FigureCanvasAgg(figure)
    draw_convergence(figure.add_subplot(), report)
    figure.savefig(path)
