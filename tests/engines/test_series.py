"""The recurrence is held to the equations of motion that it restates."""

import itertools

import mpmath
import numba
import numpy as np
import pytest
from longball.model.motion import Forces, acceleration

from longball.engines.series import extend

ORDER = 20


class Exactly:
    """As much of a number system as the equations of motion ask for."""

    exact = staticmethod(mpmath.mpf)
    sqrt = staticmethod(mpmath.sqrt)


def series(drag, lift, gravity, u, w):
    """Return the coefficients of u and w up to ORDER, in mpmath's working precision."""
    coefficients = [[mpmath.mpf(0)] * (ORDER + 1) for _ in range(3)]
    us, ws, speeds = coefficients
    first = 1 if u == w == 0 else 0
    us[0], ws[0] = u, w
    speeds[first] = gravity if first else mpmath.sqrt(u * u + w * w)
    for n in range(ORDER):
        extend(n, drag, lift, gravity, us, ws, speeds, first)
    return us, ws


def value(coefficients, t):
    return mpmath.polyval(coefficients[::-1], t)


def rate(coefficients, t):
    return value([n * c for n, c in enumerate(coefficients)][1:], t)


FORCES = [(0.0075, 0.0037, 9.8), (0.0075, 0.0, 9.8), (0.0, -0.0037, 9.8), (0.0075, 0.0037, 0.0)]
VELOCITIES = [(30.0, 20.0), (0.0, 25.0), (-12.0, -31.0), (0.0, 0.0)]
NOTHING_MOVES = (FORCES[3], VELOCITIES[3])


@pytest.mark.parametrize(
    ("constants", "velocity"),
    [case for case in itertools.product(FORCES, VELOCITIES) if case != NOTHING_MOVES],
)
def test_series_satisfies_the_equations_of_motion(constants, velocity):
    # Cut off after order N, the series misses the acceleration by C t^N or less; an error in any
    # of its coefficients by t^(N-1) or more. At 1e-9 s the two are far apart.
    with mpmath.workdps(400):
        drag, lift, gravity, u, w = map(mpmath.mpf, constants + velocity)
        us, ws = series(drag, lift, gravity, u, w)
        forces = Forces(drag or None, lift or None, gravity or None, always_up=False)
        accelerate = acceleration(forces, Exactly)

        def missed(t):
            du, dw = accelerate(value(us, t), value(ws, t))
            return mpmath.hypot(rate(us, t) - du, rate(ws, t) - dw)

        t = mpmath.mpf("1e-9")
        assert mpmath.log(missed(t) / missed(t / 2), 2) > ORDER - 0.001


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
