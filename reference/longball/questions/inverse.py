"""Inverse problems: the scene that fits what was measured, and the launch that hits a target.

Both use Gauss-Newton (`scipy.optimize.least_squares`) with the derivatives of
`longball.engines.tangent`, which have about twelve digits. Measurements without noise return the
unknowns to about ten.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
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
from longball.model.arrays import Array
from longball.model.inputs import require_inputs, value_of, with_values
from longball.model.numbers import Undecided
from longball.model.plain import column_of, is_number
from longball.model.quantities import doubles, unknown
from longball.model.scene import Scene
from longball.solution import error_of, real_numbers

# Singular values below this fraction of the largest count as 0. Derivatives have about twelve
# digits; two are a margin.
_DETERMINED = 1e-10

# Relative step below which the search ends: a smaller one is rounding.
_CONVERGED = 1e-15
_MOST_STEPS = 100
_MET = 1e-6  # relative: what a fit without a freedom may miss, far above what it does miss

_POINT = ("t", "x", "y", "z")


@dataclass(frozen=True)
class Fit:
    """The scene that fits a measurement best.

    Attributes
    ----------
    scene
        The scene with the numbers found.
    value
        The numbers found, by name.
    sigma
        Their standard errors; NaN if `sigma` is not given and there are as many unknowns as
        measurements, so that the scatter of these is not known.
    covariance
        Of the numbers found, shape (n, n), in the order of `value`.
    residuals
        Measured minus computed, in standard deviations; of points, shape (points, 3).
    chi_squared
        The sum of their squares.
    freedom
        Degrees of freedom: measurements minus unknowns.
    """

    scene: Any  # of the kind that was given
    value: Mapping[str, float]
    sigma: Mapping[str, float]
    covariance: Array
    residuals: Array
    chi_squared: float
    freedom: int

    def __getitem__(self, name: str) -> float:
        """Return a number found."""
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

    values: Array  # shape (m,)
    names: tuple[str, ...]  # of each
    shape: tuple[int, ...]  # of the residuals
    place: NDArray[np.intp]  # where each stands among these
    # From a scene, unknowns and an engine to what is measured, and its derivatives, shape (m, n)
    model: Callable[[Scene, Sequence[str], PathEngine], tuple[Array, Array]]


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
        with these columns; NaN is not measured. Or numbers of the result by name, such as
        ``{"landing.distance": 118.2, "landing.hang_time": 5.3}``.
    scene
        As `solve` takes it, with what is known, and values of the unknowns to start from.
    unknowns
        Numbers of the scene, such as ``air.drag_coefficient``; or ``launch.`` and an argument of
        `longball.launch`, such as ``launch.speed``.
    sigma
        Standard deviations of the measurements, in their units: one number, one for each of x, y
        and z, or by name. If left out, they are taken as equal, and estimated from the residuals.
    engine, options
        As `solve` takes them.

    Raises
    ------
    InvalidScene
        If `scene` is not a valid scene.
    ValueError
        If the scene has no number of a name; if there are fewer measurements than unknowns; if
        `measured` or `sigma` has another form.
    CannotSolve
        If the measurements do not determine the unknowns: the message gives the direction in which
        these are free. If the scene to start from has no such result, or no scene near it fits.

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
    deviations = _deviations(sigma, data)
    if not names:
        raise ValueError("unknowns: name at least one number of the scene")
    if len(data.values) < len(names):
        raise ValueError(
            f"measured: {len(data.values)} numbers cannot determine {len(names)} unknowns; measure "
            "more, or fix some of the unknowns"
        )
    x, residuals, jacobian = _least_squares(asked, names, data, deviations, solver)

    # As many numbers as unknowns are met exactly, or not at all.
    if len(names) == len(data.values):
        missed = np.abs(residuals * deviations)
        if (missed > _MET * np.maximum(np.abs(data.values), 1.0)).any():
            worst = int(np.argmax(missed))
            near = ", ".join(f"{n} = {v:.6g}" for n, v in zip(names, x, strict=True))
            raise CannotSolve(
                f"no scene fits: the nearest, with {near}, misses {data.names[worst]} by "
                f"{missed[worst]:.3g}"
            )

    # How well each is determined: (Jᵀ J)⁻¹ in standard deviations of the measurements. If these are
    # not given, the scatter about the fit stands for them: χ² would be the degrees of freedom.
    root = _determined(names, jacobian)
    freedom = len(data.values) - len(names)
    chi_squared = float(residuals @ residuals)
    scale = 1.0 if sigma is not None else (chi_squared / freedom if freedom else math.nan)
    covariance = scale * (root @ root.T)
    value = dict(zip(names, x, strict=True))
    shown = np.full(data.shape, math.nan)
    shown.reshape(-1)[data.place] = residuals
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
    """Return the fitted unknowns, the residuals, and the derivatives of what is computed."""
    start = np.array([value_of(scene, name) for name in names])

    # The search asks for residuals and derivatives at the same point, which are solved together.
    @cache
    def solved_at(*x: float) -> tuple[Array, Array]:
        found, slopes = data.model(
            with_values(scene, dict(zip(names, x, strict=True))), names, engine
        )
        return (data.values - found) / deviations, slopes / deviations[:, None]

    def solved(x: Array) -> tuple[Array, Array]:
        return solved_at(*x.tolist())

    def residuals(x: Array) -> Array:
        try:
            return solved(x)[0]
        except (CannotSolve, Undecided, ValueError):
            return np.full(len(deviations), math.nan)  # too far: a shorter step is taken

    # The start is solved outside `residuals`, which would hide its error.
    _lengths(names, solved(start)[1])
    # Unknowns have different units: steps are measured by the columns of J. The search ends by the
    # size of its step alone, as a residual that is left says nothing of the unknowns' digits.
    found = least_squares(
        residuals,
        start,
        lambda x: -solved(x)[1],
        x_scale="jac",
        ftol=None,
        gtol=None,
        xtol=_CONVERGED,
        max_nfev=_MOST_STEPS,
    )
    # After all steps the gradient may have vanished within rounding: then it is found as well.
    slopes = np.linalg.norm(found.jac, axis=0) * max(np.linalg.norm(found.fun), 1e-12)
    if found.status == 0 and not (np.abs(found.grad) <= 1e-6 * slopes).all():
        raise CannotSolve(
            f"no fit is found in {_MOST_STEPS} steps; start nearer to it, or fix some unknowns"
        )
    return (found.x.tolist(), *solved(found.x))


def _determined(names: list[str], jacobian: Array) -> Array:
    """Return R with R Rᵀ = (Jᵀ J)⁻¹, if measurements determine the unknowns."""
    lengths = _lengths(names, jacobian)
    _, sizes, axes = np.linalg.svd(jacobian / lengths, full_matrices=False)
    # The columns have length 1 there: divided by their lengths, steps have units of the unknowns.
    open_ = axes[sizes <= _DETERMINED * sizes[0]] / lengths
    if len(open_):
        directions = "; and ".join(_direction(names, axis) for axis in open_)
        raise CannotSolve(
            "the measurements do not determine the unknowns: they do not change along "
            f"{directions}; fix one of these, or measure something else"
        )
    root: Array = axes.T / sizes / lengths[:, None]
    return root


def _lengths(names: list[str], jacobian: Array) -> Array:
    """Return the sizes of the columns of J; raise if measurements do not depend on an unknown."""
    lengths: Array = np.linalg.norm(jacobian, axis=0)
    if without := [name for name, x in zip(names, lengths, strict=True) if not x > 0]:
        raise CannotSolve(
            f"the measurements do not depend on {' and '.join(without)}; "
            "remove it from the unknowns"
        )
    return lengths


def _direction(names: list[str], axis: Array) -> str:
    """Return a direction in the unknowns as a text, largest part first of what matters."""
    order = [i for i in np.argsort(-np.abs(axis)) if abs(axis[i]) > 1e-6 * np.abs(axis).max()]
    # By its largest part, so that the others say how much they move per unit of it.
    axis = axis / axis[order[0]]
    return ", ".join(f"{names[i]} {axis[i]:+.4g}" for i in order)


# --- what is measured -----------------------------------------------------------------------------


def _measured(given: Any) -> _Measured:
    if isinstance(given, Mapping) and not set(_POINT) & set(given):
        return _of_result(given)
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
    seen = ~np.isnan(points)
    names = [f"{axis} at {t:g} s" for t in times for axis in _POINT[1:]]
    place = np.flatnonzero(seen)

    def model(scene: Scene, unknowns: Sequence[str], engine: PathEngine) -> tuple[Array, Array]:
        found, slopes = of_path(scene, times, unknowns, engine)
        return found.reshape(-1)[place], slopes.reshape(-1, len(unknowns))[place]

    shown = tuple(names[i] for i in place)
    return _Measured(points.reshape(-1)[place], shown, points.shape, place, model)


def of_path(
    scene: Scene, times: Array, unknowns: Sequence[str], engine: PathEngine
) -> tuple[Array, Array]:
    """Return points of a path, shape (times, 3), and derivatives, (times, 3, unknowns)."""
    # Dual numbers carry one derivative: the flight is solved once for each unknown.
    columns = []
    for name in unknowns:
        marked, speed = seeded_by(scene, name)
        found, slopes = _points(marked, times, engine)
        columns.append(slopes / speed)
    return found, np.stack(columns, axis=-1)


def _points(scene: Scene, times: Array, engine: PathEngine) -> tuple[Array, Array]:
    """Return the points of a path at some times, and their derivatives, shape (times, 3) each."""
    tangent = Tangent(engine)
    with not_beyond_a_kink():
        result, trajectory = chain.solve_with_path(scene, tangent)
        if result.error is not None:
            raise error_of(result)
        if not trajectory.legs:
            raise ValueError("an impact has no path: nothing flies in it")
        with engine.numbers.arithmetic():
            points = [_position(trajectory, tangent.numbers.exact(t)) for t in times.tolist()]
    found, slopes = (
        np.array([[float(of(x)) for x in point] for point in points]) for of in (plain_of, rate_of)
    )
    return found, slopes


def _position(trajectory: Trajectory, time: Any) -> Any:
    """Return the position at a time; after the landing, as if there were no ground.

    So measured points may lie beyond the landing of the scene to start from.
    """
    # The law of the last leg goes on: a derivative that ended at the ground would be zero there.
    leg = [leg for leg in trajectory.legs if not time < leg.begin][-1]
    return leg.frame.position(leg.flight.path.at(time - leg.begin))


def _of_result(given: Mapping[Any, Any]) -> _Measured:
    names = tuple(map(str, given))
    for name, value in given.items():
        if not (is_number(value) and math.isfinite(value)):
            raise ValueError(f"measured: {name} = {value!r}: a finite number is needed")
    values = np.array([*given.values()], float)

    def model(scene: Scene, unknowns: Sequence[str], engine: PathEngine) -> tuple[Array, Array]:
        return of_result(scene, names, unknowns, engine)

    return _Measured(values, names, values.shape, np.arange(len(values)), model)


def _deviations(sigma: Any, data: _Measured) -> Array:
    """Return the standard deviation of every measurement."""
    if isinstance(sigma, Mapping) and (missing := [x for x in data.names if x not in sigma]):
        raise ValueError(f"sigma: no value for {missing[0]}")
    given = [sigma[name] for name in data.names] if isinstance(sigma, Mapping) else sigma
    table = real_numbers("sigma", 1.0 if given is None else given)
    if not isinstance(sigma, Mapping):
        try:
            table = np.broadcast_to(table, data.shape).reshape(-1)[data.place]
        except ValueError:
            raise ValueError(
                f"sigma = {sigma!r}: one number is needed, one for each of x, y and z, or a "
                "mapping by name"
            ) from None
    if not (np.isfinite(table) & (table > 0)).all():
        raise ValueError(f"sigma = {sigma!r}: standard deviations must be positive")
    return table


def of_result(
    scene: Scene, quantities: Sequence[str], unknowns: Sequence[str], engine: PathEngine
) -> tuple[Array, Array]:
    """Return numbers of a result, shape (m,), and their derivatives, shape (m, unknowns)."""
    result = solve(scene, engine).result
    found = doubles(result)
    for name in quantities:
        if name not in found:
            raise CannotSolve(f"measured: {unknown(name, found)}; the outcome is {result.outcome}")
    slopes = [derivatives_by(scene, name, engine) for name in unknowns]
    values = np.array([found[name] for name in quantities])
    return values, np.array([[float(by[q]) for by in slopes] for q in quantities])
