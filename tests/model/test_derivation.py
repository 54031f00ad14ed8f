"""The derivation of the impulse: each step, each law, and that no law is proved of everything."""

import re

import pytest
import sympy as sp

from analysis.derivation import run
from analysis.writing import Report
from longball.model import derivation
from longball.model.derivation import (
    APPARENT_RESTITUTION,
    BALL_MASS,
    BAT_MASS,
    BAT_VELOCITY,
    BETA,
    MASS_RATIO,
    NORMAL,
    NORMAL_SPEED,
    PRINTED_E,
    REDUCED_MASS,
    RESTITUTION,
    VELOCITY,
    After,
    collide,
    on_unit_normal,
    plain_arithmetic,
)
from tests.model import impact_laws

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


def heavy_bat(velocity, bat_velocity, normal):
    """A bat that nothing moves."""
    return After(collide(velocity, bat_velocity, normal).ball, bat_velocity)


def rough_bat(velocity, bat_velocity, normal):
    """A bat with friction, equal and opposite."""
    after = collide(velocity, bat_velocity, normal)
    relative = velocity - bat_velocity
    friction = (relative - relative.dot(normal) * normal) / 10
    return After(after.ball - friction / BALL_MASS, after.bat + friction / BAT_MASS)


def weak_impulse(velocity, bat_velocity, normal):
    """Half the impulse."""
    after = collide(velocity, bat_velocity, normal)
    return After((after.ball + velocity) / 2, (after.bat + bat_velocity) / 2)


def bat_speed_forgotten(velocity, bat_velocity, normal):
    """An impulse from the ball's own velocity, instead of that relative to the bat."""
    after = collide(velocity, sp.zeros(3, 1), normal)
    return After(after.ball, bat_velocity + after.bat)


def no_collision(velocity, bat_velocity, normal):
    """Both bodies go on as they came."""
    return After(velocity, bat_velocity)


LAWS = {
    "momentum": impact_laws.momentum_residual,
    "tangential": impact_laws.tangential_residual,
    "restitution": impact_laws.restitution_residual,
    "galilean": impact_laws.galilean_residual,
}


@pytest.mark.parametrize(
    ("rule", "broken"),
    [
        (collide, set()),
        (heavy_bat, {"momentum", "restitution"}),
        (rough_bat, {"tangential"}),
        (weak_impulse, {"restitution"}),
        (bat_speed_forgotten, {"restitution", "galilean"}),
        (no_collision, {"restitution"}),
    ],
)
@pytest.mark.sampled(every=3)
def test_the_derived_rule_obeys_every_law_and_others_break_theirs(rule, broken):
    residuals = {name: sp.Matrix([law(rule)]) for name, law in LAWS.items()}
    assert {name for name, residual in residuals.items() if not residual.is_zero_matrix} == broken


def disturbed(ball, bat):
    """Build a rule that changes the velocity of one body in a way that no law allows."""

    def rule(velocity, bat_velocity, normal):
        after = collide(velocity, bat_velocity, normal)
        return After(after.ball + ball * velocity[::-1, :], after.bat + bat * bat_velocity[::-1, :])

    return rule


@pytest.mark.parametrize("law", [impact_laws.tangential_residual, impact_laws.galilean_residual])
@pytest.mark.parametrize(("ball", "bat"), [(1, 0), (0, 1)])
def test_each_body_is_held_to_the_law_in_every_component(law, ball, bat):
    """A residual of one body, or of fewer components, would prove less than it says."""
    residual = law(disturbed(ball, bat))
    assert [0 not in residual[:, body] for body in (0, 1)] == [bool(ball), bool(bat)]


@pytest.mark.parametrize(("ball", "bat"), [(1, 0), (0, 1)])
def test_momentum_is_held_to_its_law_in_every_component(ball, bat):
    assert 0 not in impact_laws.momentum_residual(disturbed(ball, bat))


def test_the_unit_normal_is_used_and_nothing_more():
    nx, ny, nz = NORMAL
    assert on_unit_normal(nx**2 + ny**2 + nz**2) == 1
    assert on_unit_normal(nx**4 - (1 - ny**2 - nz**2) ** 2) == 0
    assert on_unit_normal(nx**2 + ny**2) != 0
    assert on_unit_normal(VELOCITY.dot(NORMAL) - BAT_VELOCITY.dot(NORMAL)) != 0


def test_the_energy_balance_follows_from_the_energies_of_both_bodies():
    change = derivation.energy_change()
    expected = -REDUCED_MASS * (1 - RESTITUTION**2) * NORMAL_SPEED**2 / 2
    assert change.free_symbols == {REDUCED_MASS, RESTITUTION, NORMAL_SPEED}
    assert sp.expand(change - expected) == 0


def test_the_energy_balance_is_factored():
    """A factor 1 - ẽ² would lose digits to cancellation near ẽ = 1."""
    factors = sp.Mul.make_args(derivation.energy_change())
    assert RESTITUTION - 1 in factors
    assert RESTITUTION + 1 in factors


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


@pytest.mark.parametrize("e", [sp.Rational(41, 100), sp.Rational(45, 100), sp.Integer(0)])
@pytest.mark.parametrize("nudge", [-1, 0, 1])
def test_beyond_that_mass_ratio_and_only_there_the_energy_grows(e, nudge):
    """The condition on r and the energy of the two bodies are computed apart, and must agree."""
    r = (1 - e) / (1 + e) + sp.Rational(nudge, 10**9)
    values = {PRINTED_E: e, MASS_RATIO: r}
    restitution = derivation.printed_restitution().subs(values)
    gain = derivation.energy_change().subs({RESTITUTION: restitution})
    gain = gain.subs({REDUCED_MASS: 1, NORMAL_SPEED: -1})
    assert sp.sign(gain) == nudge
    assert bool(derivation.energy_creating_mass_ratios().subs(values)) == (nudge > 0)


# ---- oblique impact ------------------------------------------------------------------------------


def test_an_impulse_at_the_contact_keeps_what_it_must():
    """Momentum and angular momentum of both, the ball's about the contact, and the energy."""
    assert impact_laws.total_momentum_residual().is_zero_matrix
    assert impact_laws.contact_momentum_residual().is_zero_matrix
    assert impact_laws.energy_residual() == 0


def test_another_push_would_show(monkeypatch):
    """A ball that is pushed without being turned, as friction without its moment does."""
    whole = derivation.pushed

    def without_moment(before, push=derivation.PUSH):
        return whole(before, push)._replace(spin=before.spin)

    monkeypatch.setattr(derivation, "pushed", without_moment)
    assert not impact_laws.total_momentum_residual().is_zero_matrix
    assert not impact_laws.contact_momentum_residual().is_zero_matrix
    assert impact_laws.energy_residual() != 0


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
    assert impact_laws.frictionless_residual() == 0
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


@pytest.mark.parametrize("restitution", [PRINTED_E - MASS_RATIO, PRINTED_E + MASS_RATIO**2])
def test_a_threshold_is_not_read_off_a_restitution_that_has_none(monkeypatch, restitution):
    """Falling or curved in r: the condition r > threshold would not be the answer."""
    monkeypatch.setattr(derivation, "printed_restitution", lambda: restitution)
    with pytest.raises(ValueError, match="linearly"):
        derivation.energy_creating_mass_ratios()
