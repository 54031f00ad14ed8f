"""The Taylor series of a flight in time: the recurrence that the equations of motion imply.

With ``u = Σ u_n tⁿ``, ``w = Σ w_n tⁿ`` and ``V = Σ V_n tⁿ`` the equations of
`longball.model.motion.acceleration` become, order by order,

    ``V·V = u·u + w·w``
    ``(n+1) u_{n+1} = -(k_D (V·u)_n + k_L (V·w)_n)``
    ``(n+1) w_{n+1} = -(k_D (V·w)_n - k_L (V·u)_n) - g [n = 0]``

where ``(a·b)_n = Σ a_i b_{n-i}``. They are written as plain loops over sequences that can be
indexed, so that the same function runs on lists of any kind of number and, compiled by
``numba.njit``, on arrays of doubles. A force that is absent has the coefficient 0: it costs two
multiplications an order, next to the 7n of the sums, and changes no bit of what is left.
"""

from __future__ import annotations

from collections.abc import MutableSequence

from longball.model.numbers import N


def extend(
    n: int,
    drag: N,
    lift: N,
    gravity: N,
    u: MutableSequence[N],
    w: MutableSequence[N],
    speed: MutableSequence[N],
) -> None:
    """Write the coefficients ``speed[n]``, ``u[n + 1]`` and ``w[n + 1]`` from those before.

    Parameters
    ----------
    n
        Order; call it with 0, 1, 2, … in turn.
    drag, lift, gravity
        ``k_D``, ``k_L``, 1/m, and g, m/s².
    u, w
        Coefficients of the velocity, (m/s)/sⁿ, known up to n; room for one more.
    speed
        Coefficients of V, (m/s)/sⁿ, known up to n - 1; ``speed[0]``, which is not zero, is given
        by the caller, who knows how to take a root.
    """
    if n > 0:
        # V_0 V_n is half of (u·u + w·w)_n less the other products of V·V; each occurs twice but
        # for the one in the middle.
        half = u[0] * u[n] + w[0] * w[n]
        for i in range(1, (n + 1) // 2):
            half += u[i] * u[n - i] + w[i] * w[n - i] - speed[i] * speed[n - i]
        if n % 2 == 0:
            m = n // 2
            half += (u[m] * u[m] + w[m] * w[m] - speed[m] * speed[m]) / 2
        speed[n] = half / speed[0]
    along = speed[0] * u[n]
    aside = speed[0] * w[n]
    for i in range(1, n + 1):
        along += speed[i] * u[n - i]
        aside += speed[i] * w[n - i]
    u[n + 1] = -(drag * along + lift * aside) / (n + 1)
    w[n + 1] = -(drag * aside - lift * along) / (n + 1)
    if n == 0:
        w[1] -= gravity
