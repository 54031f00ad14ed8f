"""The impulse as executed: generated, and right in every kind of number."""

import math
from fractions import Fraction
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from longball.model import derivation, impact

SOURCE = Path(impact.__file__)
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
