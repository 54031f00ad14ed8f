"""Studies of a family of time steps: of a function of the step, and of a solver of scenes.

`longball.convergence.order` finds the asymptotic range of each quantity and fits the order there;
the report gives the reason for every other step. Errors are differences from the truth if it is
given; otherwise the differences between steps give them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from longball.convergence.family import PHASES, Expected, Observed, observe, step_family
from longball.convergence.report import ConvergenceReport, Lost
from longball.model.quantities import numbers
from longball.model.result import Result
from longball.model.scene import Scene, ids_of

# --- a function of the step -----------------------------------------------------------------------


def study(
    function_of_dt: Callable[[float], ArrayLike],
    steps: Sequence[float],
    *,
    truth: ArrayLike | None = None,
    expected: float | None = None,
    duration: float = 1.0,
    phases: int = 1,
) -> ConvergenceReport:
    """Evaluate a function at a family of steps, and fit the order of each of its numbers.

    Parameters
    ----------
    function_of_dt
        Function of a step, s. It returns a number or an array, of the same shape at every step;
        NaN means no value.
    steps
        Steps, s: at least five different ones, with any ratios.
    truth
        Exact values; by default, differences between steps estimate the errors.
    expected
        Theoretical order.
    duration
        Duration of the calculation, s. The number of steps bounds the effect of rounding.
    phases
        With 1, each step is evaluated once. With more, it is also evaluated slightly shortened, by
        less than one step in `duration`, to see whether the error jumps with the phase of an event
        at that time. The error of a number that jumps is the root mean square over all phases.

    Returns
    -------
    ConvergenceReport
        Its `orders` belong to ``value``, or to ``value[0]``, ``value[1, 0]`` and so on for an
        array. A number that is 0 at every step has no order.

    Raises
    ------
    ValueError
        If there are too few steps, or if the values or the truth differ in shape.

    Examples
    --------
    >>> euler = study(lambda dt: (1 - dt) ** round(1 / dt), [2.0**-k for k in range(8, 16)])
    >>> print(f"{euler.orders[0].order:.2f}, limit {euler.limits[0].value[0]:.6f}")
    1.00, limit 0.367879
    """
    shapes: dict[str, tuple[int, ...]] = {}

    def numbers_of(values: ArrayLike, where: str) -> list[Observed]:
        numbers = np.asarray(values, float)
        shapes[where] = numbers.shape
        (first, shape), (last, other) = next(iter(shapes.items())), (where, numbers.shape)
        if other != shape:
            raise ValueError(f"values of one shape are needed: {shape} {first}, {other} {last}")
        return [
            Observed("value" + (str(list(index)) if index else ""), "", np.array([[number]]))
            for index, number in np.ndenumerate(numbers)
        ]

    orders, limits = observe(
        lambda step: numbers_of(function_of_dt(step), f"at dt = {step:g}"),
        step_family(steps),
        None if truth is None else numbers_of(truth, "in truth"),
        scenes=[""], expected=expected, first=duration, last=duration, phases=phases,
        progress=lambda done, of: None,
    )  # fmt: skip
    return ConvergenceReport(
        engine=None, against_truth=truth is not None, orders=orders, limits=limits, lost=()
    )


# --- a solver of scenes ---------------------------------------------------------------------------


# Components of the quantities of an answer, by name; some may be missing.
Answered = Mapping[str, Sequence[Any]]

# Observed quantities: name in the report, unit, name in the result, and components.
ALL = slice(None)
OBSERVABLES = (
    ("plate height", "m", "plate.position", slice(2, 3)),
    ("contact time", "s", "contact.time", ALL),
    ("contact point", "m", "contact.position", ALL),
    ("exit velocity", "m/s", "impact.velocity", ALL),
    ("landing time", "s", "landing.time", ALL),
    ("landing point", "m", "landing.position", ALL),
    ("distance", "m", "landing.distance", ALL),
)


@dataclass(frozen=True)
class Sample:
    """Answer to a scene, or a part of one."""

    id: str | None
    outcome: str | None  # None if not given; it then counts as right
    values: Answered
    engine: str | None = None
    error: str | None = None


def converge(
    run: Callable[[float], Sequence[Any]],
    scenes: Sequence[Scene],
    steps: Sequence[float],
    truth: Sequence[Any] | None = None,
    expected: Expected = None,
    *,
    phases: int = PHASES,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> ConvergenceReport:
    """Solve scenes with a family of steps, and fit the order of each of `OBSERVABLES`.

    Parameters
    ----------
    run
        Function of a step, s, that solves all scenes, as `longball.solve_many` does. Results have
        the scenes' ids; a result without an id belongs to the scene at its position. Quantities may
        be missing.
    scenes
        Scenes to solve; at least one.
    steps
        Steps, s: at least five different ones, with any ratios.
    truth
        True results of the scenes; by default, the finest step decides the right outcomes.
    expected
        Theoretical order: one for all, or one for each name of `OBSERVABLES`.
    phases
        Phases of each step for a quantity that jumps.
    progress
        Function that is called with the number of runs done, and their total as known so far.

    Raises
    ------
    ValueError
        If there are too few steps, no scenes, or results that belong to no scene.
    TypeError
        If an object is not a result.
    """
    if not scenes:
        raise ValueError("there is no scene to converge in")
    # The finest step is solved first: without a truth it decides the right outcomes.
    family = step_family(steps)
    ids = ids_of(scenes)
    finest = in_order(run(float(family[-1])), ids)
    should = finest if truth is None else in_order(truth, ids)
    lost = {float(family[-1]): _lost(finest, should)}

    def evaluate(step: float) -> list[Observed]:
        results = finest
        if step != family[-1]:
            results = in_order(run(step), ids)
            lost[step] = _lost(results, should)
        return observed(results, should)

    first, last = first_and_last_event(should)
    true = None if truth is None else observed(should, should)
    orders, limits = observe(
        evaluate, family, true, scenes=ids, expected=expected, first=first, last=last,
        phases=phases, progress=progress,
    )  # fmt: skip
    missing = tuple(Lost(step=h, lost=lost[h], of=len(ids)) for h in family.tolist())
    return ConvergenceReport(
        engine=finest[0].engine, against_truth=truth is not None, orders=orders, limits=limits,
        lost=missing,
    )  # fmt: skip


def observed(results: Sequence[Sample], should: Sequence[Sample]) -> list[Observed]:
    """Return the observed numbers of results; NaN for a wrong outcome."""
    observations = []
    for name, unit, quantity, part in OBSERVABLES:
        width = max([1, *(len(end.values.get(quantity, ())[part]) for end in should)])
        values = np.full((len(results), width), np.nan)
        for scene, (result, end) in enumerate(zip(results, should, strict=True)):
            both = quantity in result.values and quantity in end.values
            if both and not _ends_otherwise(result, end):
                values[scene] = [float(x) for x in result.values[quantity][part]]
        observations.append(Observed(name, unit, values))
    return observations


def _ends_otherwise(result: Sample, end: Sample) -> bool:
    """True if a scene has a wrong outcome, or no answer."""
    # Answers that consist of points or numbers have no outcome; their numbers are compared.
    if result.outcome is None and result.error is None:
        return False
    return result.outcome != end.outcome


def _lost(results: Sequence[Sample], should: Sequence[Sample]) -> int:
    return sum(_ends_otherwise(a, b) for a, b in zip(results, should, strict=True))


def first_and_last_event(results: Sequence[Sample]) -> tuple[float, float]:
    """Return the times of the first and the last event of all scenes, s; 1 s without events."""
    names = ("plate.time", "contact.time", "landing.time")
    times = [float(r.values[name][0]) for r in results for name in names if name in r.values]
    later = [time for time in times if time > 0] or [1.0]
    return min(later), max(later)


def _as_sample(result: Any) -> Sample:
    """Return a `Sample`, a `Result`, or a `longball.Solution` as a sample."""
    result = getattr(result, "result", result)
    if isinstance(result, Sample):
        return result
    if not isinstance(result, Result):
        raise TypeError(f"a result is needed; not an object of type {type(result).__name__}")
    values: dict[str, list[Any]] = {}
    for name, number in numbers(result):
        values.setdefault(name.partition("[")[0], []).append(number)
    return Sample(result.id, result.outcome, values, result.engine, result.error)


def in_order(results: Sequence[Any], ids: Sequence[str]) -> list[Sample]:
    """Return the results in the order of the scenes; an error in place of a missing one."""
    samples = map(_as_sample, results)
    by_id = {sample.id or str(number): sample for number, sample in enumerate(samples, 1)}
    unknown = [name for name in by_id if name not in ids]
    if unknown:
        raise ValueError(f"a result belongs to no scene: its id is {unknown[0]!r}")
    return [by_id.get(name) or Sample(name, None, {}, error="there is no result") for name in ids]
