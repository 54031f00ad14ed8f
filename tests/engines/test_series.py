"""The recurrence is held to the equations of motion that it restates."""

import mpmath
import numba
import numpy as np
import pytest

from longball.engines.series import extend
from longball.model.motion import Forces, acceleration

ORDER = 20


class Digits50:
    """As much of a number system as the equations of motion ask for, to 50 digits."""

    exact = staticmethod(mpmath.mpf)
    sqrt = staticmethod(mpmath.sqrt)


def series(drag, lift, gravity, u, w):
    """Return the coefficients of u and w up to ORDER, in mpmath's working precision."""
    coefficients = [[mpmath.mpf(0)] * (ORDER + 1) for _ in range(3)]
    us, ws, speeds = coefficients
    us[0], ws[0], speeds[0] = u, w, mpmath.sqrt(u * u + w * w)
    for n in range(ORDER):
        extend(n, drag, lift, gravity, us, ws, speeds)
    return us, ws


def value(coefficients, t):
    return mpmath.polyval(coefficients[::-1], t)


def rate(coefficients, t):
    return value([n * c for n, c in enumerate(coefficients)][1:], t)


@pytest.mark.parametrize(
    ("drag", "lift", "gravity"),
    [(0.0075, 0.0037, 9.8), (0.0075, 0.0, 9.8), (0.0, -0.0037, 9.8), (0.0075, 0.0037, 0.0)],
)
@pytest.mark.parametrize(("u", "w"), [(30.0, 20.0), (0.0, 25.0), (-12.0, -31.0)])
def test_series_satisfies_the_equations_of_motion(drag, lift, gravity, u, w):
    # The series' radius of convergence is some 3 s: at 0.03 s its truncated rate misses the
    # acceleration by (1/100)^20; an error in any coefficient, even a relative 1e-6 of the last,
    # would be 1e-46 / 1e-40 of it.
    with mpmath.workdps(60):
        drag, lift, gravity, u, w = map(mpmath.mpf, (drag, lift, gravity, u, w))
        us, ws = series(drag, lift, gravity, u, w)
        forces = Forces(drag or None, lift or None, gravity or None, always_up=False)
        accelerate = acceleration(forces, Digits50)
        t = mpmath.mpf("0.03")
        du, dw = accelerate(value(us, t), value(ws, t))
        assert abs(rate(us, t) - du) < mpmath.mpf("1e-36")
        assert abs(rate(ws, t) - dw) < mpmath.mpf("1e-36")


def test_compiled_series_is_the_same():
    # Sixty roundings in a coefficient at most, none of them in a difference of near equals.
    with mpmath.workdps(30):
        truth = series(*map(mpmath.mpf, (0.0075, 0.0037, 9.8, 30.0, 20.0)))
    us, ws, speeds = np.zeros((3, ORDER + 1))
    us[0], ws[0], speeds[0] = 30.0, 20.0, np.hypot(30.0, 20.0)
    compiled = numba.njit(extend)
    for n in range(ORDER):
        compiled(n, 0.0075, 0.0037, 9.8, us, ws, speeds)
    np.testing.assert_allclose(us, np.array(truth[0], dtype=float), rtol=1e-13)
    np.testing.assert_allclose(ws, np.array(truth[1], dtype=float), rtol=1e-13)
