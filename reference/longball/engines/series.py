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
    first: int = 0,
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
        Coefficients of V, (m/s)/sⁿ, known up to n - 1, and up to `first` from the caller, who
        knows how to take a root.
    first
        Order of the first coefficient of V that is not zero: 0, or 1 for a flight that starts
        from rest, which V leaves as g t.
    """
    if n > first:
        # V_first V_n is half of the coefficient of order n + first of u·u + w·w, less the other
        # products of V·V in it; each product occurs twice but for the one in the middle.
        last = n + first
        half = u[first] * u[n] + w[first] * w[n]
        for i in range(first + 1, (last + 1) // 2):
            half += u[i] * u[last - i] + w[i] * w[last - i] - speed[i] * speed[last - i]
        if last % 2 == 0:
            m = last // 2
            half += (u[m] * u[m] + w[m] * w[m] - speed[m] * speed[m]) / 2
        speed[n] = half / speed[first]
    along = speed[0] * u[n]
    aside = speed[0] * w[n]
    for i in range(1, n + 1):
        along += speed[i] * u[n - i]
        aside += speed[i] * w[n - i]
    u[n + 1] = -(drag * along + lift * aside) / (n + 1)
    w[n + 1] = -(drag * aside - lift * along) / (n + 1)
    if n == 0:
        w[1] -= gravity
