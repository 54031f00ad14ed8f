"""Uncertainty of a result from that of its scene, J C Jᵀ, and whether first order is enough."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
from pydantic import ValidationError

from longball.api import as_engine, as_scene, differentiable, solve
from longball.engines import chain
from longball.engines.engine import CannotSolve
from longball.engines.tangent import derivatives_of
from longball.model.arrays import Array
from longball.model.inputs import listed, require_inputs, value_of, with_values
from longball.model.plain import is_number
from longball.model.quantities import doubles, unknown
from longball.model.result import Result
from longball.model.scene import Scene
from longball.solution import real_numbers

# Second-order terms above this fraction of the standard deviation cause a warning. Independent
# terms add in squares: a tenth makes the standard deviation half a percent larger.
_LARGE = 0.1

# Second-order terms below this fraction of the number itself are rounding.
_ROUNDED = 1e-12


@dataclass(frozen=True)
class Uncertainty(Mapping[str, float]):
    """Standard deviations of the numbers of a result, by name.

    Attributes
    ----------
    value
        Numbers of the result.
    sigma
        Their standard deviations to first order, the square roots of the diagonal of J C Jᵀ.
    covariance
        J C Jᵀ, shape (n, n), in the order of `value`.
    shift
        Change of each mean by the second-order term.
    second
        Standard deviation of the second-order term alone.
    warnings
        Reasons why first order is not enough, one sentence each.
    """

    value: Mapping[str, float]
    sigma: Mapping[str, float]
    covariance: Array
    shift: Mapping[str, float]
    second: Mapping[str, float]
    warnings: tuple[str, ...]

    def __getitem__(self, quantity: str) -> float:
        """Return the standard deviation of a number of the result."""
        if quantity not in self.sigma:
            raise KeyError(str(unknown(quantity, self.sigma)))
        return self.sigma[quantity]

    def __iter__(self) -> Iterator[str]:
        return iter(self.sigma)

    def __len__(self) -> int:
        return len(self.sigma)

    def __repr__(self) -> str:
        rows = (f"  {name:<22}{x:.7g} ± {self.sigma[name]:.2g}" for name, x in self.value.items())
        return "\n".join([*rows, *self.warnings])


def uncertainty(
    scene: object,
    spread: Any,
    *,
    quantities: Iterable[str] | None = None,
    engine: str = "ivp",
    **options: Any,
) -> Uncertainty:
    """Propagate the uncertainty of numbers of a scene to its result, to first order.

    The covariance of the result is J C Jᵀ, with the derivatives J of `solve`. Solutions one
    standard deviation away, along the principal axes of C and between them, give the second-order
    term. If it exceeds a tenth of the first, a `UserWarning` reports it.

    Parameters
    ----------
    scene
        As `solve` takes it.
    spread
        Standard deviations by name, in SI units, such as ``{"launch.speed": 0.5}``; or a covariance
        as a data frame with these names on both sides, or as a mapping from names to its rows.
        Names are those of numbers of the scene, or ``launch.`` and an argument of
        `longball.launch`.
    quantities
        Numbers of the result; by default all.
    engine, options
        As `solve` takes them.

    Raises
    ------
    InvalidScene
        If `scene` is invalid.
    ValueError
        If the scene has no number of that name, `spread` is not a covariance, or the result has no
        such quantity.
    CannotSolve, Undecided
        If the scene has no result, or the result no derivative.

    Examples
    --------
    >>> import longball as lb
    >>> ball = lb.Flight(launch=lb.launch(speed=46.0, angle=0.45))
    >>> spread = lb.uncertainty(ball, {"launch.speed": 0.5, "launch.angle": 0.01})
    >>> round(spread["landing.distance"], 3)
    1.203
    """
    asked, solver = as_scene(scene), differentiable(as_engine(engine, options))
    names, covariance = _covariance(asked, spread)
    result = solve(asked, solver).result
    value = _numbers(result)
    if quantities is not None:
        for quantity in (chosen := listed(quantities)):
            if quantity not in value:
                raise unknown(quantity, value)
        value = {quantity: value[quantity] for quantity in chosen}

    # A single missing derivative would make all of J C Jᵀ NaN.
    derivatives = derivatives_of(asked, value, names, solver)
    for name, reason in derivatives.refused.items():
        raise CannotSolve(f"{name}: {reason}")
    jacobian = np.array([[float(derivatives[q][name]) for name in names] for q in value])
    jacobian = jacobian.reshape(len(value), len(names))
    spread_of_result = jacobian @ covariance @ jacobian.T
    sigma = dict(zip(value, np.sqrt(np.diag(spread_of_result)).tolist(), strict=True))

    # To second order Q(z) = Q + Jz + zᵀHz/2, with z normal and of unit variance along the axes. Its
    # mean is Q + tr(H)/2, and the variance of its last term is tr(H²)/2.
    curvature, warned = _second_order(asked, result, value, names, covariance, solver)
    shift = dict(zip(value, (0.5 * np.trace(curvature, axis1=0, axis2=1)).tolist(), strict=True))
    size = np.sqrt(0.5 * np.square(curvature).sum(axis=(0, 1)))
    second = dict(zip(value, size.tolist(), strict=True))
    for name in value:
        largest = max(abs(shift[name]), second[name])
        # The 1 is the scale of a number that is exactly zero, such as a sideways landing.
        if largest > _LARGE * sigma[name] + _ROUNDED * (1.0 + abs(value[name])):
            warned.append(
                f"{name}: the second-order term is large: it shifts the mean by {shift[name]:.2g} "
                f"and has a standard deviation of {second[name]:.2g}, compared with "
                f"{sigma[name]:.2g} to first order"
            )
    for sentence in warned:
        warnings.warn(sentence, stacklevel=2)
    return Uncertainty(value, sigma, spread_of_result, shift, second, tuple(warned))


def _numbers(result: Result) -> dict[str, float]:
    """Return the continuous numbers of a result; a chord of the fence, for one, is a count."""
    return {name: x for name, x in doubles(result).items() if name not in chain.DISCRETE}


def _covariance(scene: Scene, spread: Any) -> tuple[list[str], Array]:
    """Return the names of the uncertain numbers, and their covariance."""
    given = spread.to_dict() if hasattr(spread, "to_dict") else spread
    if not isinstance(given, Mapping):
        raise TypeError(
            "spread: standard deviations by name are needed, such as {'launch.speed': 0.5}, or a "
            f"covariance; not {type(spread).__name__}"
        )
    names = require_inputs(scene, map(str, given))
    if not names:
        raise ValueError("spread: no number of the scene is uncertain; name one")
    # Numbers are standard deviations, mappings are the rows of a covariance; a mixture is an error.
    rows = [*given.values()]
    if not any(isinstance(row, Mapping) for row in rows):
        for name, sigma in zip(names, rows, strict=True):
            if not (is_number(sigma) and 0 < sigma < math.inf):
                raise ValueError(
                    f"spread: the standard deviation of {name} must be positive (got {sigma!r})"
                )
        return names, np.diag(np.square(np.array(rows, float)))
    if not all(isinstance(row, Mapping) and set(map(str, row)) == set(names) for row in rows):
        raise ValueError(
            "spread: the rows of a covariance must have the names of its columns: "
            f"{', '.join(names)}"
        )
    table = real_numbers("spread", [[row[name] for name in given] for row in rows])
    if not np.isfinite(table).all() or not np.allclose(table, table.T, rtol=1e-9, atol=0.0):
        raise ValueError("spread: a covariance must be symmetric")
    # Correlations rounded to nine digits may give slightly negative eigenvalues.
    if np.linalg.eigvalsh(_scaled(table))[0] < -1e-9:
        raise ValueError(
            "spread: a covariance cannot have a negative variance along any direction of "
            f"{', '.join(names)}; check the signs and sizes of its correlations"
        )
    return names, table


def _scaled(covariance: Array) -> Array:
    """Return the correlations of a covariance."""
    sigma = np.sqrt(np.diag(covariance))
    if not (sigma > 0).all():
        raise ValueError("spread: every variance of a covariance must be positive")
    correlations: Array = covariance / np.outer(sigma, sigma)
    return correlations


def _second_order(
    scene: Scene,
    result: Result,
    value: Mapping[str, float],
    names: list[str],
    covariance: Array,
    engine: Any,
) -> tuple[Array, list[str]]:
    """Return second derivatives along the principal axes of a covariance, and doubts.

    The shape is (axes, axes, quantities), and an axis is as long as its standard deviation. The
    differences are ``Q(a + b) - Q(a) - Q(b) + Q`` for two axes and ``Q(a) - 2 Q + Q(-a)`` for one.
    """
    # Axes of the correlations, not of the covariance: numbers have different units, and the axes
    # would depend on the choice of these.
    sigma = np.sqrt(np.diag(covariance))
    sizes, turned = np.linalg.eigh(_scaled(covariance))
    axes = (sigma[:, None] * turned * np.sqrt(np.maximum(sizes, 0.0))).T
    here = np.array([value_of(scene, name) for name in names])
    middle = np.array([*value.values()])
    doubts: list[str] = []

    def at(step: Array) -> Array:
        moved = dict(zip(names, (here + step).tolist(), strict=True))
        try:
            other = chain.solve(with_values(scene, moved), engine)
            reason = other.error or f"the outcome is {other.outcome} instead of {result.outcome}"
        except ValidationError:
            other, reason = None, "there is no such scene"
        known = {} if other is None else _numbers(other)
        if other is None or other.outcome != result.outcome or not known.keys() >= value.keys():
            where = ", ".join(f"{name} = {x:.6g}" for name, x in moved.items())
            doubts.append(f"one standard deviation away, at {where}: {reason}")
            return np.full(len(value), math.nan)
        return np.array([known[quantity] for quantity in value])

    ahead, behind = ([at(sense * axis) for axis in axes] for sense in (1.0, -1.0))
    curvature = np.empty((len(names), len(names), len(value)))
    for i, j in combinations_with_replacement(range(len(names)), 2):
        if i == j:
            curvature[i, i] = ahead[i] - 2 * middle + behind[i]
        else:
            curvature[i, j] = curvature[j, i] = at(axes[i] + axes[j]) - ahead[i] - ahead[j] + middle
    # One doubt is enough: scenes with another outcome mostly have the same reason.
    return curvature, doubts[:1]
