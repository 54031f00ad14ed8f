"""The Taylor series of sixteen flights at once, and a step along them.

The recurrence is that of `longball.engines.series`, in the order of operations that keeps sixteen
lanes of multiply-adds busy; a test holds the two together.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from longball.engines.batch.lanes import (
    WIDTH,
    aligned,
    compiled,
    fma,
    load,
    magnitude,
    splat,
    square_root,
    store,
)

Array = NDArray[np.float64]

# Rows of `Expansion.forces`.
DRAG, LIFT, GRAVITY = range(3)
# Rows of `Expansion.end`, and of a state.
S, Z, U, W, S_RANGE, Z_RANGE = range(6)


class Expansion(NamedTuple):
    """Taylor coefficients of sixteen flights; each array has the shape (rows, WIDTH).

    Attributes
    ----------
    s, z, u, w
        Coefficients of the state; row k belongs to t^k, in m/s^k and m/s^(k+1).
    speed
        Coefficients of V.
    forces
        k_D, k_L (1/m) and g (m/s²).
    step
        One row: the length of the step, s.
    end
        State after the step, and how far s and z can get from their start on the way, m.
    """

    s: Array
    z: Array
    u: Array
    w: Array
    speed: Array
    forces: Array
    step: Array
    end: Array


def room(order: int) -> Expansion:
    """Return an expansion of u and w to the power `order`, of s and z to the next."""
    rows = order + 2
    return Expansion(*(aligned(rows) for _ in range(5)), aligned(3), aligned(1), aligned(6))


def reciprocals(order: int) -> Array:
    """Return 1/k up to k = order + 1 (and 0 for k = 0)."""
    return np.array([0.0] + [1.0 / k for k in range(1, order + 2)])


@compiled
def expand(x: Expansion, inverse: Array, order: int) -> None:
    """Fill in the coefficients from those of t^0.

    With a = V u, b = V w: u' = -(k_D a + k_L b), w' = -(k_D b - k_L a) - g, and V² = u² + w².
    """
    s, z, u, w, speed = x.s, x.z, x.u, x.w, x.speed
    drag, lift, gravity = load(x.forces, DRAG), load(x.forces, LIFT), load(x.forces, GRAVITY)
    zero, half = splat(0.0), splat(0.5)
    u0, w0 = load(u, 0), load(w, 0)
    v0 = square_root(fma(u0, u0, w0 * w0))
    per_v0 = splat(1.0) / v0
    store(speed, 0, v0)
    store(s, 1, u0)
    store(z, 1, w0)
    a, b = v0 * u0, v0 * w0
    un = zero - fma(drag, a, lift * b)
    wn = fma(lift, a, zero - drag * b) - gravity
    store(u, 1, un)
    store(w, 1, wn)
    for n in range(1, order):
        # The coefficient n of V from that of V², then those of a and b. The sums run over pairs
        # (j, n - j) that leave out the ends 0 and n, which are not known until V's is.
        uu, ww, vv = zero, zero, zero
        vu, uv, vw, wv = zero, zero, zero, zero
        j, k = 1, n - 1
        while j < k:
            uj, wj, vj = load(u, j), load(w, j), load(speed, j)
            uk, wk, vk = load(u, k), load(w, k), load(speed, k)
            uu, ww, vv = fma(uj, uk, uu), fma(wj, wk, ww), fma(vj, vk, vv)
            vu, uv = fma(vj, uk, vu), fma(vk, uj, uv)
            vw, wv = fma(vj, wk, vw), fma(vk, wj, wv)
            j += 1
            k -= 1
        q, a, b = (uu + ww) - vv, vu + uv, vw + wv
        if j == k:
            uj, wj, vj = load(u, j), load(w, j), load(speed, j)
            q = fma(half, fma(uj, uj, wj * wj) - vj * vj, q)
            a, b = fma(vj, uj, a), fma(vj, wj, b)
        vn = fma(w0, wn, fma(u0, un, q)) * per_v0
        store(speed, n, vn)
        a = fma(vn, u0, fma(v0, un, a))
        b = fma(vn, w0, fma(v0, wn, b))
        per_n = splat(inverse[n + 1])
        store(s, n + 1, un * per_n)
        store(z, n + 1, wn * per_n)
        un = (zero - fma(drag, a, lift * b)) * per_n
        wn = fma(lift, a, zero - drag * b) * per_n
        store(u, n + 1, un)
        store(w, n + 1, wn)
    per_n = splat(inverse[order + 1])
    store(s, order + 1, un * per_n)
    store(z, order + 1, wn * per_n)


@compiled
def choose_steps(x: Expansion, order: int, truncation: float) -> None:
    """Choose the steps: the last two terms of the velocity stay below `truncation` times V.

    A second bound keeps V analytic: V² ≈ V₀² + S₁ t + S₂ t² has its complex zeros near V₀/√S₂ from
    an apex, and a step stays within half of that. A ball that only goes up or down needs none:
    V = ±w is analytic.
    """
    for lane in range(WIDTH):
        u0, w0, v0 = x.u[0, lane], x.w[0, lane], x.speed[0, lane]
        u1, w1 = x.u[1, lane], x.w[1, lane]
        bend = u1 * u1 + w1 * w1 + 2.0 * (u0 * x.u[2, lane] + w0 * x.w[2, lane])
        last = max(abs(x.u[order, lane]), abs(x.w[order, lane]))
        last_but_one = max(abs(x.u[order - 1, lane]), abs(x.w[order - 1, lane]))
        allowed = truncation * v0
        step = min(_root(allowed / last, order), _root(allowed / last_but_one, order - 1))
        straight = u0 == 0.0 and x.forces[LIFT, lane] == 0.0
        x.step[0, lane] = step if straight else min(step, 0.5 * v0 / np.sqrt(abs(bend)))


# The logarithm of a double to base 2, times 2^52, is its bits read as an integer, plus this, to
# within 2^52 / 11: the mantissa stands for the fraction of the logarithm.
_ZERO_OF_LOGARITHM = 1023 << 52
# Reading the root back from its bits makes it at most 1 / 0.94 times too long.
_SHORTEN = 0.94


@compiled
def _root(x: float, n: int) -> float:
    """Return a lower estimate of the n-th root, good to a tenth: all that a step needs."""
    if not x < 1e300:
        return 1e300
    bits = np.float64(x).view(np.int64)
    return _SHORTEN * np.int64((bits - _ZERO_OF_LOGARITHM) / n + _ZERO_OF_LOGARITHM).view(
        np.float64
    )


@compiled
def take_steps(x: Expansion, order: int) -> None:
    """Sum the series at the end of the steps, and the range of s and z on the way."""
    h = load(x.step, 0)
    size = magnitude(h)
    s, z = load(x.s, order + 1), load(x.z, order + 1)
    u, w = load(x.u, order), load(x.w, order)
    s_range, z_range = magnitude(s), magnitude(z)
    for k in range(order - 1, -1, -1):
        sk, zk = load(x.s, k + 1), load(x.z, k + 1)
        s, z = fma(s, h, sk), fma(z, h, zk)
        s_range, z_range = fma(s_range, size, magnitude(sk)), fma(z_range, size, magnitude(zk))
        u, w = fma(u, h, load(x.u, k)), fma(w, h, load(x.w, k))
    store(x.end, S, fma(s, h, load(x.s, 0)))
    store(x.end, Z, fma(z, h, load(x.z, 0)))
    store(x.end, U, u)
    store(x.end, W, w)
    store(x.end, S_RANGE, s_range * size)
    store(x.end, Z_RANGE, z_range * size)
