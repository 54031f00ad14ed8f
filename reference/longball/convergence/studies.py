"""Studies of a family of time steps: of a function of the step, and of a solver of scenes.

For each quantity the observed order comes from the steps in its asymptotic range, which
`longball.convergence.order` finds; the others are shown with the reason why they are left out. With
the truth at hand the errors are those against it; without, those that the differences of
neighbouring steps imply.
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
        Takes a step, s; returns a number or an array, of the same shape at every step. NaN: no
        value there.
    steps
        s; at least five different ones. Their ratio is free.
    truth
        The values without an error; if not given, the differences of neighbouring steps imply it.
    expected
        The order in theory.
    duration
        s, that the steps are taken through: their number bounds what rounding can do.
    phases
        Each step is evaluated alone if this is 1. With more, it is also shortened by less than
        one step in `duration`, to see whether the error jumps with the phase that the step has in
        an event at that time; the errors of a number that does are root mean squares over so many
        phases.

    Returns
    -------
    ConvergenceReport
        Its `orders` are those of ``value``, or ``value[0]``, ``value[1, 0]`` and so on of an array;
        a number that is 0 at every step has none.

    Raises
    ------
    ValueError
        If there are too few steps; if the values change their shape, or the truth has another one.

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


# Quantities that an implementation answers with, by name: it need not have them all.
Answered = Mapping[str, Sequence[Any]]

# What is observed of a result: what it is called here, its unit, and where it stands.
OBSERVABLES = (
    ("plate height", "m", "plate.position[2]"),
    ("contact time", "s", "contact.time"),
    ("contact point", "m", "contact.position"),
    ("exit velocity", "m/s", "impact.velocity"),
    ("landing time", "s", "landing.time"),
    ("landing point", "m", "landing.position"),
    ("distance", "m", "landing.distance"),
)


@dataclass(frozen=True)
class Sample:
    """Statement about a scene, or a part of it."""

    id: str | None
    outcome: str | None  # None if it is not said: it is then taken to be as it should
    # Quantities, each a sequence of its components, and those by names of their own.
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
        Solves all the scenes with a step, s, as `longball.solve_many` does. The results carry the
        scenes' ids; one without an id is that of the scene in its place. Samples may lack
        quantities.
    scenes
        What is solved; at least one.
    steps
        s; at least five different ones. Their ratio is free.
    truth
        Results of the scenes; without it the finest step says how each scene should end.
    expected
        The order in theory: one for all, or one for each name of `OBSERVABLES`.
    phases
        Of each step, for a quantity that jumps with them.
    progress
        Called with the runs done, and how many there are so far as is known.

    Raises
    ------
    ValueError
        If there are too few steps, no scenes, or results that belong to no scene.
    TypeError
        If a result is none.
    """
    if not scenes:
        raise ValueError("there is no scene to converge in")
    # The finest step is solved first: without truth it says how scenes should end.
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
    """Return the observed numbers of results; NaN of those with another end than expected."""
    found = []
    for name, unit, quantity in OBSERVABLES:
        width = max([1, *(len(end.values.get(quantity, ())) for end in should)])
        values = np.full((len(results), width), np.nan)
        for scene, (result, end) in enumerate(zip(results, should, strict=True)):
            both = quantity in result.values and quantity in end.values
            if both and not _ends_otherwise(result, end):
                values[scene] = [float(x) for x in result.values[quantity]]
        found.append(Observed(name, unit, values))
    return found


def _ends_otherwise(result: Sample, end: Sample) -> bool:
    """True if a scene has another end than it should have, or no answer."""
    # Answers of points alone, or of numbers, name no outcome: they are compared as they are.
    if result.outcome is None and result.error is None:
        return False
    return result.outcome != end.outcome


def _lost(results: Sequence[Sample], should: Sequence[Sample]) -> int:
    return sum(_ends_otherwise(a, b) for a, b in zip(results, should, strict=True))


def first_and_last_event(results: Sequence[Sample]) -> tuple[float, float]:
    """Return when the first and the last thing happens in any scene, s; 1 s if nothing does."""
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
        # A vector under its own name, and each component under its own.
        values.setdefault(name.partition("[")[0], []).append(number)
        values[name] = [number] if "[" in name else values[name]
    return Sample(result.id, result.outcome, values, result.engine, result.error)


def in_order(results: Sequence[Any], ids: Sequence[str]) -> list[Sample]:
    """Return the results in the order of the scenes; an error for one that is missing."""
    samples = map(_as_sample, results)
    by_id = {sample.id or str(number): sample for number, sample in enumerate(samples, 1)}
    unknown = [name for name in by_id if name not in ids]
    if unknown:
        raise ValueError(f"a result belongs to no scene: its id is {unknown[0]!r}")
    return [by_id.get(name) or Sample(name, None, {}, error="there is no result") for name in ids]
