"""Inverse problem: the scene that fits a measurement.

The method is Gauss-Newton (`scipy.optimize.least_squares`) with the derivatives of
`longball.engines.tangent`, which have about twelve digits. Measurements without noise return the
unknowns to about ten digits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from longball.api import as_engine, as_scene, differentiable, solve
from longball.engines import chain
from longball.engines.engine import CannotSolve
from longball.engines.path import Trajectory
from longball.engines.path_engine import PathEngine
from longball.engines.tangent import (
    Tangent,
    derivatives_by,
    not_beyond_a_kink,
    plain_of,
    rate_of,
    seeded_by,
)
from longball.model.arrays import Array, Flags
from longball.model.inputs import require_inputs, value_of, with_values
from longball.model.numbers import Undecided
from longball.model.plain import column_of, is_number
from longball.model.quantities import doubles, unknown
from longball.model.scene import Scene
from longball.solution import error_of, real_numbers

# Singular values below this fraction of the largest count as 0: the twelve digits of the
# derivatives, with a margin of two.
_DETERMINED = 1e-10

# Relative step below which the search ends: a smaller one is rounding.
_CONVERGED = 1e-15
_MOST_STEPS = 100
# With as many unknowns as measurements, a fit reproduces these to 1e-10, or no scene fits: a larger
# relative error than this means that none does.
_REPRODUCED = 1e-6

_POINT = ("t", "x", "y", "z")


@dataclass(frozen=True)
class Fit:
    """The scene that fits a measurement best.

    Attributes
    ----------
    scene
        The scene with the fitted values.
    value
        The fitted values, by name.
    sigma
        Their standard errors; NaN if `sigma` is not given and there are as many unknowns as
        measurements, because the scatter of the measurements is then unknown.
    covariance
        Covariance of the fitted values, shape (n, n), in the order of `value`.
    residuals
        Measured minus computed, in standard deviations; shape (points, 3) if points were given.
    chi_squared
        The sum of their squares.
    freedom
        Degrees of freedom: measurements minus unknowns.
    """

    scene: Any  # of the same kind as the given one
    value: Mapping[str, float]
    sigma: Mapping[str, float]
    covariance: Array
    residuals: Array
    chi_squared: float
    freedom: int

    def __getitem__(self, name: str) -> float:
        """Return a fitted value."""
        if name not in self.value:
            raise KeyError(str(unknown(name, self.value)))
        return self.value[name]

    def __repr__(self) -> str:
        rows = [
            f"  {name:<26}{x:.9g}" + (f" ± {error:.2g}" if math.isfinite(error) else "")
            for (name, x), error in zip(self.value.items(), self.sigma.values(), strict=True)
        ]
        rows.append(f"  chi² = {self.chi_squared:.4g}, degrees of freedom: {self.freedom}")
        return "\n".join(rows)


@dataclass(frozen=True)
class _Measured:
    """Measured values, and the function that predicts them from a scene."""

    values: Array  # NaN where nothing was measured
    names: tuple[str, ...]  # names of the others, for messages
    # A function of a scene, the n unknowns and an engine. It returns the computed values, and their
    # derivatives, shape (…, n)
    model: Callable[[Scene, Sequence[str], PathEngine], tuple[Array, Array]]

    @property
    def seen(self) -> Flags:
        """True where something was measured."""
        return ~np.isnan(self.values)


def fit(
    measured: Any,
    scene: object,
    *,
    unknowns: Iterable[str],
    sigma: Any = None,
    engine: str = "ivp",
    **options: Any,
) -> Fit:
    """Fit numbers of a scene to measurements, by least squares.

    Parameters
    ----------
    measured
        Points of a path: rows of t (s since the start of the scene), x, y, z (m), or a data frame
        with these columns; NaN for a coordinate that was not measured. Or numbers of the result by
        name, such as ``{"landing.distance": 118.2, "landing.hang_time": 5.3}``.
    scene
        As for `solve`: the known values, and starting values of the unknowns.
    unknowns
        Numbers of the scene, such as ``air.drag_coefficient``; or ``launch.`` and an argument of
        `longball.launch`, such as ``launch.speed``.
    sigma
        Standard deviations of the measurements, in their units: one number, one for each of x, y
        and z, or by name. If left out, they are taken as equal, and estimated from the residuals.
    engine, options
        As for `solve`.

    Raises
    ------
    InvalidScene
        If `scene` is not a valid scene.
    ValueError
        If the scene has no number with the name of an unknown; if there are fewer measurements than
        unknowns; if `measured` or `sigma` has the wrong form.
    CannotSolve
        If the measurements do not determine the unknowns; the message gives the combination of
        unknowns that remains free. If the result of the starting scene lacks a measured number, or
        no scene near it fits.

    Examples
    --------
    >>> import longball as lb
    >>> true = lb.Flight(launch=lb.launch(speed=46.0, angle=0.45))
    >>> seen = lb.solve(true).path.sample(20)
    >>> start = lb.Flight(launch=lb.launch(speed=40.0, angle=0.4))
    >>> found = lb.fit(seen, start, unknowns=["launch.speed", "launch.angle"], sigma=0.01)
    >>> round(found["launch.speed"], 9), round(found["launch.angle"], 9)
    (46.0, 0.45)
    """
    asked, solver = as_scene(scene), differentiable(as_engine(engine, options))
    names = require_inputs(asked, unknowns)
    data = _measured(measured)
    deviations, values = _deviations(sigma, data), data.values[data.seen]
    if not names:
        raise ValueError("unknowns: name at least one number of the scene")
    if len(values) < len(names):
        raise ValueError(
            f"measured: {len(values)} numbers cannot determine {len(names)} unknowns; measure "
            "more, or fix some of the unknowns"
        )
    x, residuals, jacobian = _least_squares(asked, names, data, deviations, solver)

    # With as many measurements as unknowns, either the fit is exact or no scene fits.
    if len(names) == len(values):
        missed = np.abs(residuals * deviations)
        if (missed > _REPRODUCED * np.maximum(np.abs(values), 1.0)).any():
            worst = int(np.argmax(missed))
            near = ", ".join(f"{n} = {v:.6g}" for n, v in zip(names, x, strict=True))
            raise CannotSolve(
                f"no scene fits: the nearest, with {near}, misses {data.names[worst]} by "
                f"{missed[worst]:.3g}"
            )

    # Covariance: (Jᵀ J)⁻¹, with J in standard deviations of the measurements. If these are not
    # given, the scatter about the fit estimates them: the scale makes χ² equal to the degrees of
    # freedom.
    root = _covariance_root(names, jacobian)
    freedom = len(values) - len(names)
    chi_squared = float(residuals @ residuals)
    scale = 1.0 if sigma is not None else (chi_squared / freedom if freedom else math.nan)
    covariance = scale * (root @ root.T)
    value = dict(zip(names, x, strict=True))
    shown = np.full(data.values.shape, math.nan)
    shown[data.seen] = residuals
    errors = np.sqrt(np.diag(covariance)).tolist()
    return Fit(
        with_values(asked, value),
        value,
        dict(zip(names, errors, strict=True)),
        covariance,
        shown,
        chi_squared,
        freedom,
    )


def _least_squares(
    scene: Scene, names: list[str], data: _Measured, deviations: Array, engine: PathEngine
) -> tuple[list[float], Array, Array]:
    """Return the fitted unknowns, the residuals, and the derivatives of the computed values."""
    start = [value_of(scene, name) for name in names]

    # SciPy calls two functions at each point; one solution gives residuals and derivatives.
    @cache
    def solved(*x: float) -> tuple[Array, Array]:
        moved = with_values(scene, dict(zip(names, x, strict=True)))
        computed, slopes = data.model(moved, names, engine)
        missed = (data.values - computed)[data.seen]
        return missed / deviations, slopes[data.seen] / deviations[:, None]

    def residuals(x: Array) -> Array:
        try:
            return solved(*x.tolist())[0]
        except (CannotSolve, Undecided, ValueError):
            # The step was too long: SciPy shortens a step whose residuals are NaN.
            return np.full(len(deviations), math.nan)

    # The start is solved outside `residuals`, which would hide an error as NaN. An unknown without
    # effect is an error of the start, too.
    _column_norms(names, solved(*start)[1])
    # Unknowns have different units, so steps are scaled by the columns of J. The search ends by the
    # size of its step alone: with noise in the measurements, the size of the residual says nothing
    # about the digits of the unknowns.
    fitted = least_squares(
        residuals,
        start,
        lambda x: -solved(*x.tolist())[1],
        x_scale="jac",
        ftol=None,
        gtol=None,
        xtol=_CONVERGED,
        max_nfev=_MOST_STEPS,
    )
    # Status 0: the last of the steps was not yet short. The result is still a solution if the
    # gradient is zero to rounding, relative to |J| |r|.
    slopes = np.linalg.norm(fitted.jac, axis=0) * max(np.linalg.norm(fitted.fun), 1e-12)
    if fitted.status == 0 and not (np.abs(fitted.grad) <= 1e-6 * slopes).all():
        raise CannotSolve(
            f"no fit in {_MOST_STEPS} steps; start nearer to it, or fix some of the unknowns"
        )
    x = fitted.x.tolist()
    return (x, *solved(*x))


def _covariance_root(names: list[str], jacobian: Array) -> Array:
    """Return R with R Rᵀ = (Jᵀ J)⁻¹; raise if the measurements do not determine the unknowns."""
    lengths = _column_norms(names, jacobian)
    _, sizes, axes = np.linalg.svd(jacobian / lengths, full_matrices=False)
    # The columns were scaled to length 1. Dividing the singular vectors by the lengths turns them
    # into steps of the unknowns in their units.
    open_ = axes[sizes <= _DETERMINED * sizes[0]] / lengths
    if len(open_):
        directions = "; and ".join(_direction(names, axis) for axis in open_)
        raise CannotSolve(
            "the measurements do not determine the unknowns: they do not change along "
            f"{directions}; fix one of these, or measure something else"
        )
    root: Array = axes.T / sizes / lengths[:, None]
    return root


def _column_norms(names: list[str], jacobian: Array) -> Array:
    """Return the norms of the columns of J; raise if measurements do not depend on an unknown."""
    lengths: Array = np.linalg.norm(jacobian, axis=0)
    if without := [name for name, x in zip(names, lengths, strict=True) if not x > 0]:
        raise CannotSolve(
            f"the measurements do not depend on {' and '.join(without)}; "
            "remove it from the unknowns"
        )
    return lengths


def _direction(names: list[str], axis: Array) -> str:
    """Describe a direction in the space of the unknowns, the largest component first."""
    order = [i for i in np.argsort(-np.abs(axis)) if abs(axis[i]) > 1e-6 * np.abs(axis).max()]
    # Divided by the largest component, the others are their changes per unit of that one.
    axis = axis / axis[order[0]]
    return ", ".join(f"{names[i]} {axis[i]:+.4g}" for i in order)


# --- measurements and their predictions -----------------------------------------------------------


def _measured(given: Any) -> _Measured:
    if isinstance(given, Mapping) and not set(_POINT) & set(given):
        for name, value in given.items():
            if not (is_number(value) and math.isfinite(value)):
                raise ValueError(f"measured: {name} = {value!r}: a finite number is needed")
        names, values = tuple(map(str, given)), np.array([*given.values()], float)
        return _Measured(values, names, partial(result_with_derivatives, names))
    if hasattr(given, "columns") or isinstance(given, Mapping):
        if missing := [name for name in _POINT if name not in given]:
            raise ValueError(
                f"measured: a column {missing[0]} is missing; points have {', '.join(_POINT)}"
            )
        table = np.column_stack([column_of(given[name]) for name in _POINT])
    else:
        table = column_of(given)
    if table.dtype != float or table.ndim != 2 or table.shape[1] < len(_POINT):
        raise ValueError(
            "measured: rows of t, x, y, z are needed, a data frame with these columns, or numbers "
            "of the result by name, such as {'landing.distance': 118.2}"
        )
    times, points = table[:, 0], table[:, 1:4]
    if not (np.isfinite(times) & (times >= 0)).all() or np.isinf(points).any():
        raise ValueError(
            "measured: every point needs a time since the start, and a number or NaN for x, y, z"
        )
    each = [f"{axis} at {t:g} s" for t in times for axis in _POINT[1:]]
    names = tuple(name for name, x in zip(each, points.flat, strict=True) if not math.isnan(x))
    return _Measured(points, names, partial(path_with_derivatives, times))


def path_with_derivatives(
    times: Array, scene: Scene, unknowns: Sequence[str], engine: PathEngine
) -> tuple[Array, Array]:
    """Return points of a path, shape (times, 3), and derivatives, (times, 3, unknowns)."""
    # Jets carry one derivative: the flight is solved once for each unknown.
    tangent, columns = Tangent(engine), []
    for name in unknowns:
        marked, speed = seeded_by(scene, name)
        with not_beyond_a_kink():
            result, trajectory = chain.solve_with_path(marked, tangent)
            if result.error is not None:
                raise error_of(result)
            if not trajectory.legs:
                raise ValueError("an impact has no path: nothing flies in it")
            with engine.numbers.arithmetic():
                points = [_position(trajectory, tangent.numbers.exact(t)) for t in times.tolist()]
        states, rates = (
            np.array([[float(of(x)) for x in point] for point in points])
            for of in (plain_of, rate_of)
        )
        columns.append(rates / speed)
    return states, np.stack(columns, axis=-1)


def _position(trajectory: Trajectory, time: Any) -> Any:
    """Return the position at a time; after the landing, as if there were no ground.

    Measured points may lie beyond the landing of the starting scene.
    """
    # The path continues by the law of the last leg. If it ended at the ground, its derivatives
    # would be zero from there on, and the search could not lengthen the flight.
    leg = [leg for leg in trajectory.legs if not time < leg.begin][-1]
    return leg.frame.position(leg.flight.path.at(time - leg.begin))


def _deviations(sigma: Any, data: _Measured) -> Array:
    """Return the standard deviation of every measurement."""
    if isinstance(sigma, Mapping) and (missing := [x for x in data.names if x not in sigma]):
        raise ValueError(f"sigma: no value for {missing[0]}")
    given = [sigma[name] for name in data.names] if isinstance(sigma, Mapping) else sigma
    table = real_numbers("sigma", 1.0 if given is None else given)
    if not isinstance(sigma, Mapping):
        try:
            table = np.broadcast_to(table, data.values.shape)[data.seen]
        except ValueError:
            raise ValueError(
                f"sigma = {sigma!r}: one number is needed, one for each of x, y and z, or a "
                "mapping by name"
            ) from None
    if not (np.isfinite(table) & (table > 0)).all():
        raise ValueError(f"sigma = {sigma!r}: standard deviations must be positive")
    return table


def result_with_derivatives(
    quantities: Sequence[str], scene: Scene, unknowns: Sequence[str], engine: PathEngine
) -> tuple[Array, Array]:
    """Return numbers of a result, shape (m,), and their derivatives, shape (m, unknowns)."""
    result = solve(scene, engine).result
    known = doubles(result)
    for name in quantities:
        if name not in known:
            raise CannotSolve(f"measured: {unknown(name, known)}; the outcome is {result.outcome}")
    slopes = [derivatives_by(scene, name, engine) for name in unknowns]
    values = np.array([known[name] for name in quantities])
    return values, np.array([[float(by[q]) for by in slopes] for q in quantities])
