"""The derivation of the impulse: its identities, each step by hand, and the printer.

That the impulse as executed keeps momentum, and obeys the restitution relation, is asked of exact
collisions in test_impact.py; of bodies that rub, by the golden data (`impact-oblique`).
"""

import re

import pytest
import sympy as sp

from analysis.derivation import run
from analysis.writing import Report
from longball.model import derivation
from longball.model.derivation import (
    APPARENT_RESTITUTION,
    ARM,
    AXIAL_INERTIA,
    BALL_MASS,
    BAT_MASS,
    BETA,
    BODIES,
    FRICTION,
    INERTIA,
    INERTIA_FACTOR,
    INVERSE_BAT_MASS,
    INVERSE_MASS,
    MASS_RATIO,
    NORMAL_SPEED,
    PRINTED_E,
    RADIUS,
    REDUCED_MASS,
    RESISTANCE,
    RESTITUTION,
    SLIP,
    TANGENTIAL_RESTITUTION,
    plain_arithmetic,
)

HALF = sp.Rational(1, 2)

# A head-on collision worked by hand: m = 1, M = 3, so μ = 3/4; V = -7, V_b = 1, so Ṽ = -8; ẽ = 1/2.
# Then Ṽ' = 4, β = 12, F̄Δt = 9, V' = 2, V_b' = -2, and the energies sum to 26 before, 8 after.
# Apart from that, r = 1/4 makes e_A = 1/5 of ẽ = 1/2.
BY_HAND = {
    "m": 1,
    "M": 3,
    "mu": sp.Rational(3, 4),
    r"\tilde{e}": HALF,
    r"\mathbf{n}": 1,
    r"\mathbf{V}": -7,
    r"\mathbf{V}_{b}": 1,
    r"\tilde{\mathbf{V}}": -8,
    r"(\tilde{\mathbf{V}} \cdot \mathbf{n})": -8,
    "beta": 12,
    r"\bar{F} \Delta t": 9,
    r"\mathbf{V}'": 2,
    r"\mathbf{V}_{b}'": -2,
    r"\tilde{\mathbf{V}}'": 4,
    r"(\tilde{\mathbf{V}}' \cdot \mathbf{n})": 4,
    r"\Delta E": -18,
    "r": sp.Rational(1, 4),
    "e": sp.Rational(1, 5),
    "e_A": sp.Rational(1, 5),
}


def at_hand_values(expression):
    """Put in the values of the collision worked by hand."""
    symbols = expression.free_symbols
    assert {symbol.name for symbol in symbols} <= BY_HAND.keys()
    return expression.subs({symbol: BY_HAND[symbol.name] for symbol in symbols})


# ---- identities ----------------------------------------------------------------------------------


def identities():
    """Yield what is derived, and what it has to be."""
    w, e, e_t = NORMAL_SPEED, RESTITUTION, TANGENTIAL_RESTITUTION
    penetrating, rebounding = derivation.roots()
    yield penetrating, -w * (1 - e)  # (A7)
    yield rebounding, -w * (1 + e)  # (A8)
    yield derivation.energy_change(), -REDUCED_MASS * (1 - e**2) * w**2 / 2
    # Eq. 10, the inverse of Nathan's, and the masses at which it creates energy.
    printed = derivation.printed_restitution()
    yield printed, PRINTED_E + PRINTED_E * MASS_RATIO + MASS_RATIO
    yield derivation.restitution_from_apparent().subs(APPARENT_RESTITUTION, PRINTED_E), printed
    yield derivation.apparent_restitution().subs(RESTITUTION, printed), PRINTED_E
    creating = derivation.energy_creating_mass_ratios()
    assert isinstance(creating, sp.StrictGreaterThan)
    yield creating.lhs, MASS_RATIO
    yield creating.rhs, (1 - PRINTED_E) / (1 + PRINTED_E)
    # Gripping and sliding leave the slip that they should.
    grip = SLIP + derivation._change(derivation.gripping_impulse())
    yield from zip(grip, (-e * SLIP[0], -e_t * SLIP[1], -e_t * SLIP[2]), strict=True)
    resistance, slide = derivation.sliding_impulse()
    slide = slide.subs(RESISTANCE, resistance)
    yield (SLIP + derivation._change(slide))[0], -e * SLIP[0]
    rubbing = sum(t * t for t in derivation.DIRECTION)
    yield slide[1] ** 2 + slide[2] ** 2, (FRICTION * slide[0]) ** 2 * rubbing
    # Without friction it is the paper's (A10) with 1/μ = K_nn, and at a pivot that of M_eff.
    paper = derivation.impulse().subs({REDUCED_MASS: 1 / INVERSE_MASS[0], w: SLIP[0]})
    yield from zip(slide.subs(FRICTION, 0), (paper, 0, 0), strict=True)
    pivot = derivation.elements()[INVERSE_MASS[0]].subs(INVERSE_BAT_MASS, 0)
    yield pivot, derivation.inverse_reduced_mass().subs(BAT_MASS, INERTIA / ARM**2)
    # A solid sphere.
    threshold = derivation.gripping_threshold().subs(INERTIA_FACTOR, sp.Rational(2, 5))
    yield threshold, sp.Rational(7, 2) * FRICTION * (1 + e) / (1 + e_t)


def test_what_is_derived_is_what_it_has_to_be():
    for number, (found, expected) in enumerate(identities()):
        assert sp.cancel(found - expected) == 0, number
    assert derivation.energy_change().free_symbols == {REDUCED_MASS, RESTITUTION, NORMAL_SPEED}
    assert derivation.energy_creating_restitutions() == sp.Interval.open(1, sp.oo)
    # As it is printed: of the slip across the bat to that along the normal.
    printed = derivation.equations()["Threshold"].subs({SLIP[0]: -2, SLIP[2]: 6})
    assert printed == sp.Eq(3, derivation.gripping_threshold())


def kinetic_energy(bodies):
    """Return the kinetic energy of ball and free bat, w = 1/M."""
    spin, rotation = bodies.spin, bodies.rotation
    ball = bodies.velocity.dot(bodies.velocity) + INERTIA_FACTOR * RADIUS**2 * spin.dot(spin)
    inertia = sp.diag(INERTIA, AXIAL_INERTIA, INERTIA)
    bat = bodies.bat_velocity.dot(bodies.bat_velocity) / INVERSE_BAT_MASS
    return (BALL_MASS * ball + bat + rotation.dot(inertia * rotation)) / 2


def energy_residual():
    """Return kinetic energy after less before less `work`: zero, for any impulse."""
    change = kinetic_energy(derivation.pushed(BODIES)) - kinetic_energy(BODIES)
    return sp.expand(change - derivation.work(derivation.slip(BODIES)).subs(derivation.elements()))


def test_any_impulse_changes_the_energy_by_its_work(monkeypatch):
    """Not if it pushes the ball without turning it, as friction without its moment does."""
    assert energy_residual() == 0
    whole = derivation.pushed

    def without_moment(before, push=derivation.PUSH):
        return whole(before, push)._replace(spin=before.spin)

    monkeypatch.setattr(derivation, "pushed", without_moment)
    assert energy_residual() != 0


# ---- the derivation as one reads it --------------------------------------------------------------


def test_every_step_holds_in_the_collision_worked_by_hand():
    false_there = {
        "Discarded root",
        "Energy created",  # ẽ = 1/2 creates none,
        "Energy created as printed",  # and r = 1/4 is below 2/3
    }
    equations = list(derivation.equations().items())
    outcome = {title: at_hand_values(equation) for title, equation in equations[:-4]}
    assert set(outcome.values()) <= {sp.true, sp.false}
    assert {title for title, holds in outcome.items() if holds == sp.false} == false_there


def test_the_report_says_what_each_equation_means(tmp_path):
    section = run(Report(tmp_path), full=False)
    steps = re.findall(r"^\d+\. \*\*(.+)\.\*\* .+\.\n\n   \$\$ (.+) \$\$$", section, re.MULTILINE)
    printed = {title: sp.latex(equation) for title, equation in derivation.equations().items()}
    assert steps == list(printed.items())


# ---- from expressions to source ------------------------------------------------------------------

X, Y = sp.symbols("x y")


@pytest.mark.parametrize(
    ("expression", "source"),
    [
        (X**2 * Y, "a * a * b"),
        (X / Y**2, "a / (b * b)"),
        ((X + Y) ** 2, "(a + b) * (a + b)"),
        (3 * X / 2, "3 * a / 2"),
        (-X / 2 - Y, "-a / 2 - b"),
    ],
)
def test_plain_arithmetic(expression, source):
    assert plain_arithmetic(expression, {X: "a", Y: "b"}) == source


@pytest.mark.parametrize(
    "expression",
    [
        sp.sqrt(X),
        sp.sin(X),
        X**3,
        X**Y,
        sp.pi * X,
        sp.Float("0.5") * X,
        X + HALF,  # a double in Python, whatever x is
        X + sp.Symbol("unnamed"),
    ],
)
def test_what_is_not_plain_arithmetic_is_refused(expression):
    with pytest.raises(ValueError, match="not plain arithmetic"):
        plain_arithmetic(expression, {X: "a", Y: "b"})


def test_the_command_writes_and_checks(tmp_path, monkeypatch, capsys):
    generated = derivation.generate()
    monkeypatch.setattr(derivation, "__file__", str(tmp_path / "derivation.py"))
    written = tmp_path / "impact.py"
    returned = "return -normal_speed * reduced_mass * (restitution + 1)"
    for altered in (returned.replace("+ 1", "- 1"), "return 0", "return (\n        0\n    )"):
        wrong = generated.replace(returned, altered)
        assert wrong != generated
        written.write_text(wrong, encoding="utf-8")
        assert derivation.main(["--check"]) == 1
        assert "run `python -m longball.model.derivation`" in capsys.readouterr().err
        assert written.read_text(encoding="utf-8") == wrong
        assert derivation.main([]) == 0
        assert written.read_text(encoding="utf-8") == generated
        capsys.readouterr()
        assert derivation.main(["--check"]) == 0
        assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("word", "other", "fault"),
    [
        ("def impulse", "def push", "has the functions"),
        ("(reduced_mass: Number, restitution", "(restitution", "not plain arithmetic"),
        ("n_x, n_y, n_z = normal", "n_x, n_y, n = normal", "not plain arithmetic"),
    ],
)
def test_a_function_that_lacks_what_it_needs_is_refused(tmp_path, monkeypatch, word, other, fault):
    text = derivation.generate().replace(word, other)
    monkeypatch.setattr(derivation, "__file__", str(tmp_path / "derivation.py"))
    (tmp_path / "impact.py").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=fault):
        derivation.generate()


def test_a_derivation_that_goes_wrong_says_so(monkeypatch):
    """The guards are there for whoever edits the derivation."""
    monkeypatch.setattr(
        derivation,
        "ball_velocity_after",
        lambda velocity, normal, impulse: velocity + sp.Matrix([impulse, 0, 0]),
    )
    monkeypatch.setattr(derivation, "restitution_equation", lambda: BETA**2)
    monkeypatch.setattr(derivation, "_FROM_BAT", sp.Matrix([1, 1, 1]))
    for derive, said in (
        (derivation.inverse_reduced_mass, "along the normal"),
        (derivation.roots, "one rebounding and one penetrating"),
        (derivation.inverse_mass, "is coupled"),
    ):
        with pytest.raises(ValueError, match=said):
            derive.__wrapped__()
