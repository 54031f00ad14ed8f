"""The Taylor series of sixteen flights at once, and a step along them.

The recurrence is that of `longball.engines.series`, in the order of operations that keeps sixteen
lanes of multiply-adds busy; a test holds the two together.
"""

from __future__ import annotations

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

# An expansion is an array of shape (blocks, order + 2, WIDTH). Row k of the first blocks is the
# coefficient of t^k of the state (m/s^k, and m/s^(k+1) for the velocity) and of the speed V.
S, Z, U, W, SPEED, FORCES, STEP, INVERSE = range(8)
# Rows of FORCES: k_D, k_L (1/m) and g (m/s²).
DRAG, LIFT, GRAVITY = range(3)
# Rows of STEP: the state at the end of the step; how far, m, s and z can get from their start on
# the way; the step, s; the time at its start, s.
S_RANGE, Z_RANGE, LENGTH, TIME = range(4, 8)
# Row k of INVERSE is 1/k.


def room(order: int) -> Array:
    """Return an expansion of u and w to the power `order`, of s and z to the next."""
    x = aligned(8, max(order + 2, 8))
    for k in range(1, order + 2):
        x[INVERSE, k] = 1.0 / k
    return x


@compiled
def expand(x: Array, order: int) -> None:
    """Fill in the coefficients from those of t^0.

    With a = V u, b = V w: u' = -(k_D a + k_L b), w' = -(k_D b - k_L a) - g, and V² = u² + w².
    """
    drag, lift, gravity = load(x, FORCES, DRAG), load(x, FORCES, LIFT), load(x, FORCES, GRAVITY)
    zero, half = splat(0.0), splat(0.5)
    u0, w0 = load(x, U, 0), load(x, W, 0)
    v0 = square_root(fma(u0, u0, w0 * w0))
    per_v0 = splat(1.0) / v0
    store(x, SPEED, 0, v0)
    store(x, S, 1, u0)
    store(x, Z, 1, w0)
    a, b = v0 * u0, v0 * w0
    un = zero - fma(drag, a, lift * b)
    wn = fma(lift, a, zero - drag * b) - gravity
    store(x, U, 1, un)
    store(x, W, 1, wn)
    for n in range(1, order):
        # The coefficient n of V from that of V², then those of a and b. The sums run over pairs
        # (j, n - j) that leave out the ends 0 and n, which are not known until V's is.
        uu, ww, vv = zero, zero, zero
        vu, uv, vw, wv = zero, zero, zero, zero
        j, k = 1, n - 1
        while j < k:
            uj, wj, vj = load(x, U, j), load(x, W, j), load(x, SPEED, j)
            uk, wk, vk = load(x, U, k), load(x, W, k), load(x, SPEED, k)
            uu, ww, vv = fma(uj, uk, uu), fma(wj, wk, ww), fma(vj, vk, vv)
            vu, uv = fma(vj, uk, vu), fma(vk, uj, uv)
            vw, wv = fma(vj, wk, vw), fma(vk, wj, wv)
            j += 1
            k -= 1
        q, a, b = (uu + ww) - vv, vu + uv, vw + wv
        if j == k:
            uj, wj, vj = load(x, U, j), load(x, W, j), load(x, SPEED, j)
            q = fma(half, fma(uj, uj, wj * wj) - vj * vj, q)
            a, b = fma(vj, uj, a), fma(vj, wj, b)
        vn = fma(w0, wn, fma(u0, un, q)) * per_v0
        store(x, SPEED, n, vn)
        a = fma(vn, u0, fma(v0, un, a))
        b = fma(vn, w0, fma(v0, wn, b))
        per_n = load(x, INVERSE, n + 1)
        store(x, S, n + 1, un * per_n)
        store(x, Z, n + 1, wn * per_n)
        un = (zero - fma(drag, a, lift * b)) * per_n
        wn = fma(lift, a, zero - drag * b) * per_n
        store(x, U, n + 1, un)
        store(x, W, n + 1, wn)
    per_n = load(x, INVERSE, order + 1)
    store(x, S, order + 1, un * per_n)
    store(x, Z, order + 1, wn * per_n)


@compiled
def choose_steps(x: Array, order: int, truncation: float) -> None:
    """Choose the steps: the last two terms of the velocity stay below `truncation` times V.

    A second bound keeps V analytic: V² ≈ V₀² + S₁ t + S₂ t² has its complex zeros near V₀/√S₂ from
    an apex, and a step stays within half of that. A ball that only goes up or down needs none:
    V = ±w is analytic.
    """
    for lane in range(WIDTH):
        u0, w0, v0 = x[U, 0, lane], x[W, 0, lane], x[SPEED, 0, lane]
        u1, w1 = x[U, 1, lane], x[W, 1, lane]
        bend = u1 * u1 + w1 * w1 + 2.0 * (u0 * x[U, 2, lane] + w0 * x[W, 2, lane])
        last = max(abs(x[U, order, lane]), abs(x[W, order, lane]))
        last_but_one = max(abs(x[U, order - 1, lane]), abs(x[W, order - 1, lane]))
        allowed = truncation * v0
        step = min(_root(allowed / last, order), _root(allowed / last_but_one, order - 1))
        straight = u0 == 0.0 and x[FORCES, LIFT, lane] == 0.0
        x[STEP, LENGTH, lane] = step if straight else min(step, 0.5 * v0 / np.sqrt(abs(bend)))


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
def take_steps(x: Array, order: int) -> None:
    """Sum the series at the end of the steps, and the range of s and z on the way."""
    h = load(x, STEP, LENGTH)
    size = magnitude(h)
    s, z = load(x, S, order + 1), load(x, Z, order + 1)
    u, w = load(x, U, order), load(x, W, order)
    s_range, z_range = magnitude(s), magnitude(z)
    for k in range(order - 1, -1, -1):
        sk, zk = load(x, S, k + 1), load(x, Z, k + 1)
        s, z = fma(s, h, sk), fma(z, h, zk)
        s_range, z_range = fma(s_range, size, magnitude(sk)), fma(z_range, size, magnitude(zk))
        u, w = fma(u, h, load(x, U, k)), fma(w, h, load(x, W, k))
    store(x, STEP, S, fma(s, h, load(x, S, 0)))
    store(x, STEP, Z, fma(z, h, load(x, Z, 0)))
    store(x, STEP, U, u)
    store(x, STEP, W, w)
    store(x, STEP, S_RANGE, s_range * size)
    store(x, STEP, Z_RANGE, z_range * size)
