"""The impulse as executed: generated, and right in every kind of number."""

import math
from fractions import Fraction
from pathlib import Path

from flint import arb, fmpq
from hypothesis import given
from hypothesis import strategies as st

from longball.model import derivation, impact

SOURCE = Path(impact.__file__)
UNIT_ROUNDOFF = Fraction(1, 2**53)


def gamma(operations, unit_roundoff=UNIT_ROUNDOFF):
    """Bound on the relative error of so many roundings (Higham 2002, Lemma 3.1)."""
    return operations * unit_roundoff / (1 - operations * unit_roundoff)


# ---- exact collisions ----------------------------------------------------------------------------


def fractions(low, high):
    """Fractions of a size that doubles hold exactly, so that no input is rounded."""
    return st.integers(math.ceil(low * 2**12), math.floor(high * 2**12)).map(
        lambda numerator: Fraction(numerator, 2**12)
    )


def unit_normal(a, b):
    """Rational point on the unit sphere, by stereographic projection."""
    scale = 1 + a * a + b * b
    return 2 * a / scale, 2 * b / scale, (scale - 2) / scale


vectors = st.tuples(*[fractions(-60, 60)] * 3)
normals = st.builds(unit_normal, fractions(-3, 3), fractions(-3, 3))
masses = fractions(0.125, 2)
restitutions = fractions(0, 1.5)
speeds = fractions(-100, 100)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b, strict=True))


@given(vectors, vectors, normals, masses, masses, restitutions)
def test_collisions_in_exact_arithmetic(velocity, bat_velocity, normal, m, M, restitution):
    """Momentum, tangential velocity, restitution and energy, without a rounding error."""
    assert dot(normal, normal) == 1
    approach = minus(velocity, bat_velocity)
    mu = impact.reduced_mass(m, M)
    strength = impact.impulse(mu, restitution, dot(approach, normal))
    ball = impact.velocity_after(velocity, normal, m, strength)
    bat = impact.velocity_after(bat_velocity, normal, M, -strength)
    separation = minus(ball, bat)

    assert 1 / mu == 1 / m + 1 / M
    for i in range(3):
        assert m * ball[i] + M * bat[i] == m * velocity[i] + M * bat_velocity[i]
    assert dot(separation, normal) == -restitution * dot(approach, normal)
    for before, after in ((velocity, ball), (bat_velocity, bat)):
        change = minus(after, before)
        assert change == tuple(dot(change, normal) * component for component in normal)

    energy = (m * dot(velocity, velocity) + M * dot(bat_velocity, bat_velocity)) / 2
    energy_after = (m * dot(ball, ball) + M * dot(bat, bat)) / 2
    change = impact.energy_change(mu, restitution, dot(approach, normal))
    assert change == energy_after - energy
    if dot(approach, normal) != 0:
        assert (change > 0) == (restitution > 1)
        assert (change == 0) == (restitution == 1)


# ---- every kind of number ------------------------------------------------------------------------


def assert_rounded_well(convert, back, unit_roundoff, m, M, restitution, speed, velocity, normal):
    """Compare with exact arithmetic on the same inputs; the bounds count the roundings.

    `convert` rounds once, if it must; `back` is exact.
    """
    mu = impact.reduced_mass(m, M)
    strength = impact.impulse(mu, restitution, speed)
    change = impact.energy_change(mu, restitution, speed)

    computed = back(impact.reduced_mass(convert(m), convert(M)))
    assert abs(computed - mu) <= gamma(3, unit_roundoff) * mu

    # The reduced mass is rounded once on its way in, so one is added to the operations of each.
    rounded_mu = convert(mu)
    computed = back(impact.impulse(rounded_mu, convert(restitution), convert(speed)))
    assert abs(computed - strength) <= gamma(4, unit_roundoff) * abs(strength)

    # Dividing by 2 is exact, the other six are not. No allowance for cancellation near ẽ = 1.
    computed = back(impact.energy_change(rounded_mu, convert(restitution), convert(speed)))
    assert abs(computed - change) <= gamma(7, unit_roundoff) * abs(change)

    # Mass and velocity are exact; impulse and normal are rounded on their way in.
    exact = impact.velocity_after(velocity, normal, m, strength)
    computed = impact.velocity_after(
        tuple(map(convert, velocity)), tuple(map(convert, normal)), convert(m), convert(strength)
    )
    for before, component, truth, found in zip(velocity, normal, exact, computed, strict=True):
        size = abs(before) + abs(strength * component / m)
        assert abs(back(found) - truth) <= gamma(5, unit_roundoff) * size


near_one = st.builds(
    lambda sign, power: 1 + sign * Fraction(1, 2**power),
    st.sampled_from([-1, 1]),
    st.integers(8, 52),
)
collisions = st.tuples(masses, masses, restitutions | near_one, speeds, vectors, normals)


@given(collisions)
def test_doubles_lose_no_more_than_their_roundings(collision):
    assert_rounded_well(float, Fraction, UNIT_ROUNDOFF, *collision)


def ball(x, radius=0.0):
    return arb(fmpq(x.numerator, x.denominator)) + arb(0, radius)


def middle_and_radius(enclosure):
    """Both without rounding: arb's own containment test would round a fraction to a ball first."""
    parts = enclosure.mid().man_exp(), enclosure.rad().man_exp()
    middle, radius = (Fraction(int(man)) * Fraction(2) ** int(exp) for man, exp in parts)
    return middle, radius


def contains(enclosure, x):
    middle, radius = middle_and_radius(enclosure)
    return abs(x - middle) <= radius


@given(collisions, st.integers(-8, 8))
def test_ball_arithmetic_contains_the_exact_result(collision, off):
    """Also when the inputs are known to a millionth only, and the truth is anywhere inside."""
    m, M, restitution, speed, velocity, normal = collision
    radius = 2.0**-20

    def wide(x):
        return ball(x + Fraction(radius) * off / 8, radius)

    mu = impact.reduced_mass(m, M)
    strength = impact.impulse(mu, restitution, speed)
    after = impact.velocity_after(velocity, normal, m, strength)
    change = impact.energy_change(mu, restitution, speed)
    for known in (ball, wide):
        assert contains(impact.reduced_mass(known(m), known(M)), mu)
        scalars = known(mu), known(restitution), known(speed)
        assert contains(impact.impulse(*scalars), strength)
        assert contains(impact.energy_change(*scalars), change)
        enclosures = impact.velocity_after(
            tuple(map(known, velocity)), tuple(map(known, normal)), known(m), known(strength)
        )
        assert all(map(contains, enclosures, after))


def test_a_known_collision():
    """The collision worked by hand in test_derivation, so that the sign of n is told too."""
    mu = impact.reduced_mass(1, 3)
    strength = impact.impulse(mu, 0.5, -8.0)
    normal = (Fraction(2, 3), Fraction(2, 3), Fraction(1, 3))
    assert (mu, strength) == (0.75, 9.0)
    assert impact.energy_change(mu, 0.5, -8.0) == -18.0
    assert impact.velocity_after((-10, 1, 2), normal, 1, 9) == (-4, 7, 5)


# ---- the file ------------------------------------------------------------------------------------


def test_the_file_is_what_the_derivation_generates():
    assert SOURCE.read_text(encoding="utf-8") == derivation.generate()
