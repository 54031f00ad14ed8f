"""The lemmas of the proof: each a bound, its statement and its proof.

All bounds hold from 0 to h. A *value* depends on time through the flight; an *approximation* is a
polynomial that ought to be near it. |·| of a polynomial or a value is its largest size from 0 to h.
An infinite bound says that nothing is known.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from flint import arb, arb_poly

INFINITE = arb.pos_inf()


def largest(polynomial: arb_poly, h: arb) -> arb:
    """Bound ``|p|``.

    Evaluated on the ball around 0 of radius h, p contains its values at all times of it.
    """
    return abs(polynomial(arb(0, h))).upper()


def least(polynomial: arb_poly, h: arb) -> arb:
    """Bound the values of p from below: ``p = p_0 + t q`` is at least ``p_0 - h |q|``."""
    return (polynomial[0] - h * largest(polynomial.right_shift(1), h)).lower()


# --- the distance of a node's polynomial from the function of its arguments' polynomials ----------


def combination_error(terms: Iterable[tuple[arb, arb]]) -> arb:
    """Bound the error of ``Σ c x``, given each c and the error of each x: ``Σ |c| e``.

    By the triangle inequality.
    """
    return sum((abs(c) * error for c, error in terms), arb(0)).upper()


def product_error(a: arb, b: arb, error_a: arb, error_b: arb) -> arb:
    """Bound the error of ``a b``: ``|a| e_b + |b| e_a + e_a e_b``.

    `a` and `b` are the sizes of the approximations A and B. With the values a = A + α, b = B + β,
    ``a b - A B = A β + B α + α β``.
    """
    return (a * error_b + b * error_a + error_a * error_b).upper()


def root_error(residual: arb, error: arb, least: arb) -> arb:
    """Bound the error of a positive N for ``√a``: ``(|r| + e) / min N``, where ``r = N² - A``.

    A is the approximation of a, which is not negative, and e the error of A. Since
    ``N² - a = r + (A - a)`` and ``N² - a = (N - √a) (N + √a)``, in which the second factor is at
    least N. If a power of t divides both r and N, it may be divided out of both, if e = 0.
    """
    return _ratio(residual + error, least)


def quotient_error(
    residual: arb, quotient: arb, error_top: arb, error_bottom: arb, bottom: arb
) -> arb:
    """Bound the error of N for ``a / b``: ``(|r| + |N| e_b + e_a) / (min |B| - e_b)``.

    ``r = N B - A``, where A and B are the approximations of a and b; `quotient` is |N|, `bottom`
    is min |B|. Since ``b (N - a/b) = N b - a = r + N (b - B) + (A - a)`` and |b| >= |B| - e_b.
    """
    return _ratio(residual + quotient * error_bottom + error_top, bottom - error_bottom)


def exponential_error(
    start: arb, residual: arb, rate: arb, error: arb, exponential: arb, h: arb
) -> arb:
    """Bound the error of N for ``eᵃ``.

    With ``r = N' - A' N``, `start` the size of ``N - e^A`` at t = 0, `rate` = |A'|, `exponential`
    = |N|, the bound is ``E = (start + h |r|) exp(h |A'|)`` for ``N - e^A``, and for ``N - eᵃ``

        ``E + (|N| + E) (exp(e) - 1)``.

    Since ``(N - e^A)' = A' (N - e^A) + r``, ``N - e^A`` is at the time t what it was at 0 times
    ``e^{A(t) - A(0)}``, plus ``∫ r(s) e^{A(t) - A(s)} ds``, and A moves by at most h |A'|. And
    ``|eᵃ - e^A| = e^A |e^{a - A} - 1|``.
    """
    own = (start + h * residual) * (h * rate).exp()
    return (own + (exponential + own) * error.expm1()).upper()


def logarithm_error(start: arb, residual: arb, error: arb, least: arb, h: arb) -> arb:
    """Bound the error of N for ``ln a``: ``start + h |r| / min A + e / (min A - e)``.

    ``r = A N' - A'`` and `start` is the size of ``N - ln A`` at t = 0; ``(N - ln A)' = r / A``. The
    slope of ln at x is ``1/x``, and both A and a are at least ``min A - e``.
    """
    return (start + h * _ratio(residual, least) + _ratio(error, least - error)).upper()


def _ratio(top: arb, bottom: arb) -> arb:
    return (top / bottom).upper() if bottom > 0 else INFINITE


# --- from the defect to the error -----------------------------------------------------------------


def norm(components: Sequence[arb], weights: Sequence[float]) -> arb:
    """Bound the weighted norm ``√(Σ (w_i x_i)²)`` of a vector."""
    total = arb(0)
    for weight, x in zip(weights, components, strict=True):
        total += (weight * x) * (weight * x)
    return total.upper().sqrt().upper()


def logarithmic_norm(matrix: Sequence[Sequence[arb]], weights: Sequence[float]) -> arb:
    """Bound the logarithmic norm of a matrix J that belongs to the weighted norm.

    That is the largest eigenvalue of the symmetric part S of ``W J W⁻¹``, W = diag(weights). The
    eigenvalues of a symmetric n × n matrix have the mean ``m = tr S / n`` and the variance
    ``‖S - m‖² / n`` (Frobenius), so that none exceeds

        ``m + √((n - 1) / n) ‖S - m‖``,

    for n = 2 with equality (Wolkowicz & Styan, Linear Algebra Appl. 29 (1980) 471, Theorem 2.1).
    """
    # (W J W⁻¹)_ij = J_ij w_i/w_j. Of S only the diagonal and twice the other elements are needed.
    n = len(matrix)
    mean = sum((arb(matrix[i][i]) for i in range(n)), arb(0)) / n
    squares = arb(0)
    for i in range(n):
        off = matrix[i][i] - mean
        squares += off * off
        for j in range(i):
            scale = weights[i] / weights[j]
            twice = matrix[i][j] * scale + matrix[j][i] / scale
            squares += twice * twice / 2
    return (mean + (squares.upper() * (n - 1) / n).sqrt()).upper()


def growth(rates: Iterable[tuple[arb, arb]]) -> arb:
    """Bound how much an error grows: ``exp(Σ max(λ, 0) h)`` over pieces of length h.

    `rates` has a bound λ of the logarithmic norm on each piece, and its length.
    """
    return sum((rate * h for rate, h in rates if not rate <= 0), arb(0)).exp().upper()


def error_bound(error: arb, defect: arb, growth: arb) -> tuple[arb, arb]:
    """Bound the error e = v - p at the time t by ``early + late t``; return the two.

    v solves ``v' = f(v)``, p has the defect ``|p' - f(p)| <= δ``, and the logarithmic norm of f's
    derivative is at most λ between them. Then ``|e|' <= λ |e| + δ`` (Hairer, Nørsett, Wanner,
    *Solving Ordinary Differential Equations I*, Theorem I.10.6), and

        ``|e(t)| <= (|e(0)| + δ t) exp(∫ max(λ, 0))``.

    Existence. λ is a bound on a convex *tube*, all that is within a distance of p, in which f's
    derivative is bounded. So a solution that starts in the tube exists as long as it stays there,
    and there the inequality holds. If the bound is less than the tube's radius from 0 to h, then
    the solution never reaches the tube's edge, and exists until h.
    """
    return (error * growth).upper(), (defect * growth).upper()
