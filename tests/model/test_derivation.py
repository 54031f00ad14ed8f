"""The derivation of the impulse: each step, and what an impulse at the contact keeps.

That the impulse as executed keeps momentum, and obeys the restitution relation, is asked of exact
collisions in test_impact.py.
"""

import re

import pytest
import sympy as sp

from analysis.derivation import run
from analysis.writing import Report
from longball.model import derivation
from longball.model.derivation import (
    APPARENT_RESTITUTION,
    AXIAL_INERTIA,
    BALL_MASS,
    BAT_MASS,
    BAT_VELOCITY,
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
    ROTATION,
    SLIP,
    SPIN,
    VELOCITY,
    collide,
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


# ---- the derivation ------------------------------------------------------------------------------


def test_the_roots_are_the_papers():
    w, e = NORMAL_SPEED, RESTITUTION
    penetrating, rebounding = derivation.roots()
    assert sp.expand(penetrating + w * (1 - e)) == 0
    assert sp.expand(rebounding + w * (1 + e)) == 0


def test_an_oblique_collision_worked_by_hand():
    """As head-on above, but with Ṽ = (-12, 0, 0) and n = (2, 2, 1)/3, so Ṽ·n = -8 and F̄Δt = 9."""
    after = collide(sp.Matrix([-10, 1, 2]), sp.Matrix([2, 1, 2]), sp.Matrix([2, 2, 1]) / 3)
    assert at_hand_values(after.ball) == sp.Matrix([-4, 7, 5])
    assert at_hand_values(after.bat) == sp.Matrix([0, -1, 1])


# ---- the laws ------------------------------------------------------------------------------------


def test_the_energy_balance_follows_from_the_energies_of_both_bodies():
    change = derivation.energy_change()
    expected = -REDUCED_MASS * (1 - RESTITUTION**2) * NORMAL_SPEED**2 / 2
    assert change.free_symbols == {REDUCED_MASS, RESTITUTION, NORMAL_SPEED}
    assert sp.expand(change - expected) == 0


def test_energy_is_created_exactly_above_one():
    assert derivation.energy_creating_restitutions() == sp.Interval.open(1, sp.oo)


# ---- the printed coefficient of restitution ------------------------------------------------------


def test_the_printed_restitution_is_eq_10():
    e, r = PRINTED_E, MASS_RATIO
    assert sp.expand(derivation.printed_restitution() - (e + e * r + r)) == 0


def test_the_printed_restitution_is_the_inverse_of_nathans():
    inverse = derivation.restitution_from_apparent()
    assert inverse.subs(APPARENT_RESTITUTION, PRINTED_E).equals(derivation.printed_restitution())
    printed = {RESTITUTION: derivation.printed_restitution()}
    assert sp.cancel(derivation.apparent_restitution().subs(printed)) == PRINTED_E


def test_the_printed_restitution_exceeds_one_exactly_above_a_mass_ratio():
    e, r = PRINTED_E, MASS_RATIO
    condition = derivation.energy_creating_mass_ratios()
    assert isinstance(condition, sp.StrictGreaterThan)
    assert condition.lhs == r
    assert sp.cancel(condition.rhs - (1 - e) / (1 + e)) == 0


# ---- oblique impact ------------------------------------------------------------------------------


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


def contact_momentum_residual():
    """Return the change of β R ω + n × V, the ball's angular momentum about the contact: zero.

    Its normal part says that the spin about the normal stays as it is. Any friction obeys it.
    """
    normal, after = sp.Matrix([1, 0, 0]), derivation.pushed(BODIES)
    turned = INERTIA_FACTOR * RADIUS * (after.spin - SPIN)
    return (turned + normal.cross(after.velocity - VELOCITY)).applyfunc(sp.cancel)


def total_momentum_residual():
    """Return the changes of momentum and angular momentum of ball and free bat: zero.

    Angular momentum is about the bat's centre; two columns.
    """
    after = derivation.pushed(BODIES)
    moved = BALL_MASS * (after.velocity - VELOCITY)
    momentum = moved + (after.bat_velocity - BAT_VELOCITY) / INVERSE_BAT_MASS
    spin = INERTIA_FACTOR * BALL_MASS * RADIUS**2 * (after.spin - SPIN)
    bat = sp.diag(INERTIA, AXIAL_INERTIA, INERTIA) * (after.rotation - ROTATION)
    angular = (derivation._FROM_BAT - derivation._FROM_BALL).cross(moved) + spin + bat
    return sp.Matrix.hstack(momentum, angular).applyfunc(sp.cancel)


def frictionless_residual():
    """Return the sliding impulse without friction less the paper's (A10), 1/μ = K_nn: zero."""
    resistance, found = derivation.sliding_impulse()
    push = found.subs(RESISTANCE, resistance).subs(FRICTION, 0)
    paper = derivation.impulse().subs({REDUCED_MASS: 1 / INVERSE_MASS[0], NORMAL_SPEED: SLIP[0]})
    return sp.cancel(push[0] - paper) + abs(push[1]) + abs(push[2])


def test_an_impulse_at_the_contact_keeps_what_it_must():
    """Momentum and angular momentum of both, the ball's about the contact, and the energy."""
    assert total_momentum_residual().is_zero_matrix
    assert contact_momentum_residual().is_zero_matrix
    assert energy_residual() == 0


def test_another_push_would_show(monkeypatch):
    """A ball that is pushed without being turned, as friction without its moment does."""
    whole = derivation.pushed

    def without_moment(before, push=derivation.PUSH):
        return whole(before, push)._replace(spin=before.spin)

    monkeypatch.setattr(derivation, "pushed", without_moment)
    assert not total_momentum_residual().is_zero_matrix
    assert not contact_momentum_residual().is_zero_matrix
    assert energy_residual() != 0


def test_a_coupled_impulse_is_not_solved_by_components(monkeypatch):
    monkeypatch.setattr(derivation, "_FROM_BAT", sp.Matrix([1, 1, 1]))
    with pytest.raises(ValueError, match="is coupled"):
        derivation.inverse_mass.__wrapped__()


def test_gripping_and_sliding_satisfy_the_restitution_relations():
    e, e_t = RESTITUTION, derivation.TANGENTIAL_RESTITUTION
    g = derivation.SLIP
    grip = g + derivation._change(derivation.gripping_impulse())
    wanted = sp.Matrix([-e * g[0], -e_t * g[1], -e_t * g[2]])
    assert (grip - wanted).applyfunc(sp.cancel).is_zero_matrix
    resistance, slide = derivation.sliding_impulse()
    slide = slide.subs(derivation.RESISTANCE, resistance)
    assert sp.cancel((g + derivation._change(slide))[0] + e * g[0]) == 0
    rubbed = slide[1] ** 2 + slide[2] ** 2
    y, t = derivation.DIRECTION
    assert sp.cancel(rubbed - (derivation.FRICTION * slide[0]) ** 2 * (y * y + t * t)) == 0


def test_the_papers_impulse_is_the_frictionless_limit():
    assert frictionless_residual() == 0
    pivot = derivation.elements()[derivation.INVERSE_MASS[0]].subs(derivation.INVERSE_BAT_MASS, 0)
    effective_mass = derivation.INERTIA / derivation.ARM**2
    assert sp.expand(pivot - derivation.inverse_reduced_mass().subs(BAT_MASS, effective_mass)) == 0


def test_the_threshold_of_a_solid_sphere_is_seven_halves():
    found = derivation.gripping_threshold()
    e, e_t = RESTITUTION, derivation.TANGENTIAL_RESTITUTION
    solid = found.subs(derivation.INERTIA_FACTOR, sp.Rational(2, 5))
    expected = sp.Rational(7, 2) * derivation.FRICTION * (1 + e) / (1 + e_t)
    assert sp.cancel(solid - expected) == 0
    # As it is printed: of the slip across the bat to that along the normal.
    printed = derivation.equations()["Threshold"].subs(
        {derivation.SLIP[0]: -2, derivation.SLIP[2]: 6}
    )
    assert printed == sp.Eq(3, found)


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
    with pytest.raises(ValueError, match="along the normal"):
        derivation.inverse_reduced_mass.__wrapped__()
    monkeypatch.setattr(derivation, "restitution_equation", lambda: BETA**2)
    with pytest.raises(ValueError, match="one rebounding and one penetrating"):
        derivation.roots.__wrapped__()
