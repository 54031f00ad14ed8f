"""The impulse between ball and bat, derived from momentum and restitution, and its consequences.

The module follows the paper's Appendix A, whose equations are cited as (A1) to (A10); equations of
the main text are cited by their printed number. As there, the bodies do not rotate at first. The
derivation is followed by the change of energy, proved in the components of three-dimensional
vectors with a general unit normal, and by the meaning of the paper's coefficient of restitution
(Eq. 10). Then comes the impact of rotating bodies with friction, whose limit is the paper's, and
last the printer that writes the return statements of :mod:`longball.model.impact`::

    python -m longball.model.derivation            # write them
    python -m longball.model.derivation --check    # fail if they would change

The laws of the impulse are tested in ``tests/model/test_impact.py``, of bodies that rub by golden
data.
"""

from __future__ import annotations

import argparse
import ast
import sys
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

from longball.extras import MissingExtra, naming_extras

try:
    with naming_extras():
        import sympy as sp
except MissingExtra as missing:
    if __name__ == "__main__":
        sys.exit(str(missing))
    raise

# --------------------------------------------------------------------------------------------------
# Notation
# --------------------------------------------------------------------------------------------------

# Only what a step of the derivation needs is assumed of a symbol.
BALL_MASS = sp.Symbol("m")
BAT_MASS = sp.Symbol("M")
REDUCED_MASS = sp.Symbol("mu")
IMPULSE = sp.Symbol(r"\bar{F} \Delta t", real=True)
BETA = sp.Symbol("beta", real=True)
# Zero is allowed; the two roots of the restitution relation then coincide.
RESTITUTION = sp.Symbol(r"\tilde{e}", nonnegative=True)
# The normal points from the bat to the ball, so the normal speed is negative before a collision.
NORMAL_SPEED = sp.Symbol(r"(\tilde{\mathbf{V}} \cdot \mathbf{n})", negative=True)

VELOCITY = sp.Matrix(sp.symbols("V_x V_y V_z"))
BAT_VELOCITY = sp.Matrix(sp.symbols("V_bx V_by V_bz"))
NORMAL = sp.Matrix(sp.symbols("n_x n_y n_z"))

# Section III.C: r = m / M_eff, and the e in Eq. 10 for ẽ.
MASS_RATIO = sp.Symbol("r")
PRINTED_E = sp.Symbol("e", nonnegative=True)
APPARENT_RESTITUTION = sp.Symbol("e_A", real=True)

# Oblique impact: bodies rotate, with friction. The basis is right-handed: along the normal, along
# the bat's axis, and perpendicular to both. The normal is perpendicular to the axis.
RADIUS, BAT_RADIUS = sp.symbols("R r_b")
INERTIA_FACTOR = sp.Symbol("beta_I")  # I = β m R²; 2/5 for a solid sphere
INERTIA, AXIAL_INERTIA = sp.symbols("J J_a")  # of the bat: across and along its axis
INVERSE_BAT_MASS = sp.Symbol("w")  # 1/M of a free bat, 0 at a pivot
ARM = sp.Symbol("d")  # along the bat, from the pivot or the bat's centre to the contact
TANGENTIAL_RESTITUTION = sp.Symbol("e_T")
FRICTION = sp.Symbol("mu_f")
PUSH = sp.Matrix(sp.symbols("P_n P_y P_t"))
SLIP = sp.Matrix(sp.symbols("g_n g_y g_t"))
DIRECTION = sp.symbols("t_y t_t")
INVERSE_MASS = sp.symbols("K_nn K_ny K_yy K_tt")
RESISTANCE = sp.Symbol("D")
SPIN = sp.Matrix(sp.symbols("omega_x omega_y omega_z"))
ROTATION = sp.Matrix(sp.symbols("Omega_x Omega_y Omega_z"))

# The same vectors as single symbols, for printed equations.
_V, _V_BAT, _V_RELATIVE = sp.symbols(r"\mathbf{V} \mathbf{V}_{b} \tilde{\mathbf{V}}")
_V_AFTER, _V_BAT_AFTER, _V_RELATIVE_AFTER = sp.symbols(
    r"\mathbf{V}' \mathbf{V}_{b}' \tilde{\mathbf{V}}'"
)
_N = sp.Symbol(r"\mathbf{n}")
_NORMAL_SPEED_AFTER = sp.Symbol(r"(\tilde{\mathbf{V}}' \cdot \mathbf{n})")
_ENERGY_CHANGE = sp.Symbol(r"\Delta E", real=True)


class After(NamedTuple):
    """Velocities of the two bodies after the collision, column vectors in m/s."""

    ball: sp.Matrix
    bat: sp.Matrix


Rule = Callable[[sp.Matrix, sp.Matrix, sp.Matrix], After]
"""A collision rule: velocity of the ball, velocity of the bat, unit normal -> velocities after."""


def on_unit_normal(expression: sp.Expr) -> sp.Expr:
    """Reduce an expression by |n| = 1 to a form that is zero exactly if it vanishes there.

    The expression is rational in the components of the normal and any other symbols. The result is
    the factored remainder of the numerator on division by n·n - 1, over the denominator.
    """
    # n·n - 1 has the leading coefficient 1 in n_z, so the remainder is unique. It is irreducible,
    # so a polynomial that vanishes on the whole unit sphere is a multiple of it.
    numerator, denominator = sp.fraction(sp.together(expression))
    remainder = sp.rem(sp.expand(numerator), NORMAL.dot(NORMAL) - 1, NORMAL[2])
    return sp.factor(remainder / denominator)


# --------------------------------------------------------------------------------------------------
# The derivation: Appendix A
# --------------------------------------------------------------------------------------------------


def ball_velocity_after(velocity: sp.Expr, normal: sp.Expr, impulse: sp.Expr) -> sp.Expr:
    """Velocity of the ball after an impulse along the normal (A1).

    Written for anything that adds and scales: column vectors in the proofs, letters in `steps`.
    """
    return velocity + normal * impulse / BALL_MASS


def bat_velocity_after(velocity: sp.Expr, normal: sp.Expr, impulse: sp.Expr) -> sp.Expr:
    """Velocity of the bat, which receives the opposite impulse by Newton's third law (A2)."""
    return velocity - normal * impulse / BAT_MASS


@cache
def inverse_reduced_mass() -> sp.Expr:
    """Factor 1/μ = 1/m + 1/M of the impulse in the relative velocity: (A3), (A1) minus (A2)."""
    before = VELOCITY - BAT_VELOCITY
    after = ball_velocity_after(VELOCITY, NORMAL, IMPULSE) - bat_velocity_after(
        BAT_VELOCITY, NORMAL, IMPULSE
    )
    change = after - before
    factors = {sp.cancel(change[i] / (IMPULSE * NORMAL[i])) for i in range(3)}
    if len(factors) != 1:
        raise ValueError(f"the relative velocity does not change along the normal: {factors}")
    return sp.expand(factors.pop())


@cache
def reduced_mass() -> sp.Expr:
    """Mass μ that the impulse meets, in terms of m and M (A3)."""
    return sp.cancel(1 / inverse_reduced_mass())


def restitution_equation() -> sp.Expr:
    """Polynomial in β whose roots satisfy the restitution relation (A4) to (A6).

    (Ṽ'·n)² - ẽ² (Ṽ·n)² with Ṽ'·n = Ṽ·n + β and β = F̄Δt/μ. Squaring takes the moduli off both
    sides, and no root is added because both sides are non-negative.
    """
    normal_speed_after = NORMAL_SPEED + BETA
    return sp.expand(normal_speed_after**2 - RESTITUTION**2 * NORMAL_SPEED**2)


@cache
def roots() -> tuple[sp.Expr, sp.Expr]:
    """Both values of β that satisfy the restitution relation: β₁ (A7), and β₂ (A8).

    β₁ leaves Ṽ'·n = ẽ Ṽ·n, with the same sign: the ball continues into the bat. At ẽ = 1, β₁ is 0,
    and the ball would pass through as if there were no bat. β₂ leaves Ṽ'·n = -ẽ Ṽ·n: the bodies
    separate, as they must. Raises `ValueError` if the roots are not one of each kind.
    """
    solutions = [sp.factor(root) for root in sp.solve(restitution_equation(), BETA)]
    rebounding = [root for root in solutions if sp.expand(NORMAL_SPEED + root).is_nonnegative]
    penetrating = [root for root in solutions if sp.expand(NORMAL_SPEED + root).is_nonpositive]
    if not (len(solutions) == 2 and len(rebounding) == 1 and len(penetrating) == 1):
        raise ValueError(f"expected one rebounding and one penetrating root, found {solutions}")
    return penetrating[0], rebounding[0]


@cache
def impulse() -> sp.Expr:
    """Impulse F̄Δt along the normal, in terms of μ, ẽ and Ṽ·n (A9), (A10); Eq. 9 times Δt."""
    _, rebounding = roots()
    (solution,) = sp.solve(sp.Eq(BETA, IMPULSE / REDUCED_MASS), IMPULSE)
    return sp.factor(solution.subs(BETA, rebounding))


def collide(velocity: sp.Matrix, bat_velocity: sp.Matrix, normal: sp.Matrix) -> After:
    """Velocities after the collision of two free bodies under the derived impulse: a `Rule`.

    They are in terms of m, M and ẽ; the unit normal points from the bat to the ball.
    """
    normal_speed = (velocity - bat_velocity).dot(normal)
    strength = impulse().xreplace({REDUCED_MASS: reduced_mass(), NORMAL_SPEED: normal_speed})
    return After(
        ball_velocity_after(velocity, normal, strength),
        bat_velocity_after(bat_velocity, normal, strength),
    )


# --------------------------------------------------------------------------------------------------
# What the collision changes
# --------------------------------------------------------------------------------------------------


@cache
def energy_change(rule: Rule = collide) -> sp.Expr:
    """Change of the kinetic energy of both bodies: -½ μ (1 - ẽ²) (Ṽ·n)².

    It is factored so that it is accurate near ẽ = 1. Nothing of this is assumed. The energies of
    the bodies are written in components, V_x is eliminated in favour of Ṽ·n and m in favour of μ;
    that all other components, the normal and M then drop out is the result.
    """
    after = rule(VELOCITY, BAT_VELOCITY, NORMAL)
    change = (
        BALL_MASS * (after.ball.dot(after.ball) - VELOCITY.dot(VELOCITY))
        + BAT_MASS * (after.bat.dot(after.bat) - BAT_VELOCITY.dot(BAT_VELOCITY))
    ) / 2
    (v_x,) = sp.solve((VELOCITY - BAT_VELOCITY).dot(NORMAL) - NORMAL_SPEED, VELOCITY[0])
    in_normal_speed = on_unit_normal(change.subs(VELOCITY[0], v_x))
    (ball_mass,) = sp.solve(sp.Eq(1 / REDUCED_MASS, inverse_reduced_mass()), BALL_MASS)
    return sp.factor(in_normal_speed.subs(BALL_MASS, ball_mass))


def energy_creating_restitutions() -> sp.Set:
    """Values of ẽ >= 0 at which the two bodies together gain energy: ẽ > 1."""
    gain = sp.cancel(energy_change() / (REDUCED_MASS * NORMAL_SPEED**2))
    return sp.solveset(gain > 0, RESTITUTION, sp.Interval(0, sp.oo))


# --------------------------------------------------------------------------------------------------
# What the printed coefficient of restitution means: Eq. 10
# --------------------------------------------------------------------------------------------------


def printed_restitution() -> sp.Expr:
    """Coefficient of restitution as Eq. 10 prints it, with r = m / M_eff."""
    return PRINTED_E * (1 + MASS_RATIO) + MASS_RATIO


@cache
def apparent_restitution() -> sp.Expr:
    """Rebound speed over incident speed of a ball that meets a bat at rest head-on.

    (ẽ - r) / (1 + r), Nathan's e_A (Am. J. Phys. 71, 134 (2003), the paper's nathan03), from the
    derived collision with a bat of mass M_eff = m / r.
    """
    incident_speed = sp.Symbol("v")
    velocity = -incident_speed * NORMAL
    after = collide(velocity, sp.zeros(3, 1), NORMAL)
    ratio = on_unit_normal(after.ball.dot(NORMAL) / incident_speed)
    return sp.cancel(ratio.subs(BAT_MASS, BALL_MASS / MASS_RATIO))


def restitution_from_apparent() -> sp.Expr:
    """Coefficient of restitution from a measured e_A, the inverse of `apparent_restitution`.

    e_A (1 + r) + r: Eq. 10, with e_A where the paper has e.
    """
    (solution,) = sp.solve(sp.Eq(APPARENT_RESTITUTION, apparent_restitution()), RESTITUTION)
    return sp.collect(sp.expand(solution), APPARENT_RESTITUTION)


def energy_creating_mass_ratios() -> sp.Rel:
    """Condition on r = m / M_eff under which Eq. 10 creates energy: r > (1 - e) / (1 + e).

    Equivalent to ẽ > 1, since Eq. 10 rises linearly with r for every e >= 0, which is checked.
    """
    excess = printed_restitution() - energy_creating_restitutions().inf
    slope = sp.diff(excess, MASS_RATIO)
    if not (slope.is_positive and sp.diff(slope, MASS_RATIO) == 0):
        raise ValueError(f"the printed restitution does not rise linearly with r: slope {slope}")
    (threshold,) = sp.solve(excess, MASS_RATIO)
    return sp.Gt(MASS_RATIO, threshold)


# --------------------------------------------------------------------------------------------------
# Oblique impact: bodies that turn, and Coulomb friction
# --------------------------------------------------------------------------------------------------

_FROM_BALL = sp.Matrix([-RADIUS, 0, 0])  # to the contact
_FROM_BAT = sp.Matrix([BAT_RADIUS, ARM, 0])


class Bodies(NamedTuple):
    """Motion of ball and bat: of the ball's centre, and of the bat's pivot or centre."""

    velocity: sp.Matrix
    spin: sp.Matrix
    bat_velocity: sp.Matrix
    rotation: sp.Matrix


BODIES = Bodies(VELOCITY, SPIN, BAT_VELOCITY, ROTATION)


def pushed(before: Bodies, push: sp.Matrix = PUSH) -> Bodies:
    """Return the motion after the ball is pushed at the contact, and the bat back.

    Momentum and angular momentum of each body: V' = V + P/m, I ω' = I ω - R n × P, and the like
    for the bat about its pivot, or with 1/M about its centre.
    """
    inertia = INERTIA_FACTOR * BALL_MASS * RADIUS**2
    turned = sp.diag(1 / INERTIA, 1 / AXIAL_INERTIA, 1 / INERTIA) * _FROM_BAT.cross(push)
    return Bodies(
        before.velocity + push / BALL_MASS,
        before.spin + _FROM_BALL.cross(push) / inertia,
        before.bat_velocity - INVERSE_BAT_MASS * push,
        before.rotation - turned,
    )


def slip(bodies: Bodies = BODIES) -> sp.Matrix:
    """Return the velocity of the ball relative to the bat at the contact."""
    ball = bodies.velocity + bodies.spin.cross(_FROM_BALL)
    return ball - bodies.bat_velocity - bodies.rotation.cross(_FROM_BAT)


@cache
def inverse_mass() -> sp.Matrix:
    """Return K, 3 × 3, by which an impulse at the contact changes the relative velocity there.

    It is symmetric, and nothing couples to the direction across normal and bat, which is checked.
    """
    matrix = (slip(pushed(BODIES)) - slip(BODIES)).jacobian(PUSH).applyfunc(sp.expand)
    if matrix != matrix.T or matrix[0, 2] != 0 or matrix[1, 2] != 0:
        raise ValueError(f"the impulse across normal and bat is coupled: {matrix}")
    return matrix


def _change(push: sp.Matrix) -> sp.Matrix:
    """Return K P, in terms of the elements of K."""
    k_nn, k_ny, k_yy, k_tt = INVERSE_MASS
    return sp.Matrix([[k_nn, k_ny, 0], [k_ny, k_yy, 0], [0, 0, k_tt]]) * push


@cache
def gripping_impulse() -> sp.Matrix:
    """Return the impulse that leaves -ẽ of the normal part of the slip, and -e_T of the rest.

    That is friction's, if it can be had: if its tangential part is at most μ_f times its normal
    part. e_T = 0 lets the ball roll, 1 is a superball, -1 rubs nothing.
    """
    e, e_t = RESTITUTION, TANGENTIAL_RESTITUTION
    wanted = [-(1 + e) * SLIP[0], -(1 + e_t) * SLIP[1], -(1 + e_t) * SLIP[2]]
    solution = sp.solve(_change(PUSH) - sp.Matrix(wanted), list(PUSH), dict=True)[0]
    return PUSH.subs(solution).applyfunc(sp.factor)


@cache
def sliding_impulse() -> tuple[sp.Expr, sp.Matrix]:
    """Return the impulse of a ball that slides: P = P_n (n - μ_f t), P_n from the restitution.

    In terms of D = n·K(n - μ_f t), which comes first. Where that is not positive the bodies jam: no
    impulse parts them.
    """
    along = sp.Matrix([1, *(-FRICTION * t for t in DIRECTION)])
    resistance = _change(along)[0]
    normal = -(1 + RESTITUTION) * SLIP[0] / RESISTANCE
    return resistance, normal * along


def work(slip: sp.Matrix = SLIP) -> sp.Expr:
    """Return the change of the kinetic energy that an impulse makes: P·(g + K P/2)."""
    return PUSH.dot(slip + _change(PUSH) / 2)


def elements() -> dict[sp.Symbol, sp.Expr]:
    """Return the elements of K in terms of masses and inertias."""
    k = inverse_mass()
    return dict(zip(INVERSE_MASS, (k[0, 0], k[0, 1], k[1, 1], k[2, 2]), strict=True))


@cache
def gripping_threshold() -> sp.Expr:
    """Return |g_t|/|g_n| at which a ball on a body that nothing moves begins to slide.

    μ_f (1 + ẽ)(1 + 1/β)/(1 + e_T); for a solid sphere, β = 2/5, 7/2 μ_f (1 + ẽ)/(1 + e_T).
    """
    fixed = {x: sp.limit(sp.limit(k, INERTIA, sp.oo), AXIAL_INERTIA, sp.oo).subs(
        INVERSE_BAT_MASS, 0) for x, k in elements().items()}  # fmt: skip
    # Sliding across the bat with -g_n = 1: the friction that is needed equals what there is.
    push = gripping_impulse().subs(fixed).subs({SLIP[0]: -1, SLIP[1]: 0})
    (threshold,) = sp.solve(-push[2] - FRICTION * push[0], SLIP[2])
    return sp.factor(threshold)


# --------------------------------------------------------------------------------------------------
# The derivation as one reads it
# --------------------------------------------------------------------------------------------------


def _equal(name: str, value: sp.Matrix) -> sp.Eq:
    return sp.Eq(sp.MatrixSymbol(name, *value.shape), sp.ImmutableMatrix(value))


def equations() -> dict[str, sp.Basic]:
    """Return the derivation and its consequences in order, by title, to print with `sympy.latex`.

    The right-hand sides are the expressions that the functions above derive.
    """
    penetrating, rebounding = roots()
    momentum = BALL_MASS * _V + BAT_MASS * _V_BAT
    momentum_after = BALL_MASS * _V_AFTER + BAT_MASS * _V_BAT_AFTER
    resistance, sliding = sliding_impulse()
    return {
        "Ball": sp.Eq(_V_AFTER, ball_velocity_after(_V, _N, IMPULSE)),
        "Bat": sp.Eq(_V_BAT_AFTER, bat_velocity_after(_V_BAT, _N, IMPULSE)),
        "Momentum": sp.Eq(momentum_after, momentum),
        "Reduced mass": sp.Eq(1 / REDUCED_MASS, inverse_reduced_mass()),
        "Relative velocity": sp.Eq(_V_RELATIVE_AFTER, _V_RELATIVE + _N * IMPULSE / REDUCED_MASS),
        "Normal component": sp.Eq(_NORMAL_SPEED_AFTER, NORMAL_SPEED + BETA),
        "Restitution": sp.Eq(sp.Mul(*(BETA - root for root in roots())), 0),
        "Discarded root": sp.Eq(BETA, penetrating),
        "Root of the rebound": sp.Eq(BETA, rebounding),
        "Impulse": sp.Eq(IMPULSE, impulse()),
        "Energy": sp.Eq(_ENERGY_CHANGE, energy_change()),
        "Energy created": sp.Contains(RESTITUTION, energy_creating_restitutions()),
        "Apparent restitution": sp.Eq(APPARENT_RESTITUTION, apparent_restitution()),
        "Apparent restitution, inverted": sp.Eq(RESTITUTION, restitution_from_apparent()),
        "Printed restitution": sp.Eq(RESTITUTION, printed_restitution()),
        "Energy created as printed": energy_creating_mass_ratios(),
        "Inverse mass at the contact": _equal("K", inverse_mass()),
        "Grip": _equal(r"\mathbf{P}", gripping_impulse()),
        "Slide": _equal(r"\mathbf{P}", sliding.subs(RESISTANCE, resistance)),
        "Threshold": sp.Eq(sp.Abs(SLIP[2] / SLIP[0]), gripping_threshold()),
    }


# --------------------------------------------------------------------------------------------------
# From expressions to impact.py
# --------------------------------------------------------------------------------------------------

# Names of scalars in impact.py; components have the names of their symbols.
_NAMES = {
    BALL_MASS: "mass",
    BAT_MASS: "bat_mass",
    REDUCED_MASS: "reduced_mass",
    RESTITUTION: "restitution",
    NORMAL_SPEED: "normal_speed",
    IMPULSE: "impulse",
    RADIUS: "radius",
    BAT_RADIUS: "bat_radius",
    INERTIA_FACTOR: "inertia_factor",
    INVERSE_BAT_MASS: "inverse_bat_mass",
    INERTIA: "inertia",
    AXIAL_INERTIA: "axial_inertia",
    ARM: "arm",
    TANGENTIAL_RESTITUTION: "tangential_restitution",
    FRICTION: "friction",
    RESISTANCE: "resistance",
}


class _ProductsForPowers(ast.NodeTransformer):
    """Replaces x**2 by x * x, which every number type supports and rounds once."""

    # No higher power occurs; `plain_arithmetic` would reject it.

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        self.generic_visit(node)
        if isinstance(node.op, ast.Pow) and ast.unparse(node.right) == "2":
            return ast.BinOp(node.left, ast.Mult(), node.left)
        return node


def plain_arithmetic(expression: sp.Expr, names: dict[sp.Symbol, str]) -> str:
    """Print an expression as Python for every kind of number: + - * / of whole numbers and names.

    Other expressions are rejected, and so is a fraction of two numbers, such as the half in x +
    1/2: Python would round it to a double before another number type is involved.
    """
    renamed = expression.xreplace({symbol: sp.Symbol(name) for symbol, name in names.items()})
    tree = _ProductsForPowers().visit(ast.parse(str(renamed), mode="eval").body)
    allowed = (ast.Name, ast.Load, ast.BinOp, ast.UnaryOp, ast.USub)
    operators = (ast.Add, ast.Sub, ast.Mult, ast.Div)
    for node in ast.walk(tree):
        whole_number = isinstance(node, ast.Constant) and isinstance(node.value, int)
        known_name = not isinstance(node, ast.Name) or node.id in names.values()
        bare_fraction = (
            isinstance(node, ast.BinOp)
            and isinstance(node.left, ast.Constant)
            and isinstance(node.right, ast.Constant)
        )
        plain = whole_number or isinstance(node, allowed + operators)
        if not (plain and known_name) or bare_fraction:
            raise ValueError(f"{renamed} is not plain arithmetic: {ast.dump(node)}")
    return ast.unparse(tree)


def _in_space(components: sp.Matrix) -> sp.Matrix:
    """Return a vector of components along the normal, along the bat, and across both in space."""
    n_x, _, n_z = NORMAL
    return sp.Matrix([[n_x, 0, -n_z], [0, 1, 0], [n_z, 0, n_x]]) * components


def _impact() -> Path:
    return Path(__file__).with_name("impact.py")


def _derived() -> dict[str, sp.Expr | sp.Matrix]:
    """Return the expression of each function of impact.py."""
    to_components = _in_space(sp.eye(3)).T
    on_axis = Bodies(*(to_components * vector for vector in BODIES))
    moved = pushed(Bodies(*(sp.zeros(3, 1) for _ in BODIES)))
    resistance, sliding = sliding_impulse()
    return {
        "reduced_mass": reduced_mass(),
        "impulse": impulse(),
        "velocity_after": ball_velocity_after(VELOCITY, NORMAL, IMPULSE),
        "energy_change": energy_change(),
        "slip": slip(on_axis).subs(ARM, 0),
        "inverse_mass": sp.Matrix([*elements().values()]),
        "gripping_impulse": gripping_impulse(),
        "sliding_resistance": resistance,
        "sliding_impulse": sliding,
        "velocity_after_push": VELOCITY + _in_space(moved.velocity),
        "spin_after_push": SPIN + _in_space(moved.spin),
        "push_energy": work(),
    }


def generate() -> str:
    """Return the text of impact.py with the derived return statements."""
    text = _impact().read_text(encoding="utf-8")
    lines, derived = text.splitlines(keepends=True), _derived()
    functions = [node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef)]
    if (there := [function.name for function in functions]) != [*derived]:
        raise ValueError(f"impact.py has the functions {there}, and derived are {[*derived]}")
    # From the end, so that line numbers before a replaced statement stay valid.
    for function in reversed(functions):
        last, result = function.body[-1], derived[function.name]
        inside = {argument.arg for argument in function.args.args}
        for node in ast.walk(function):
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                inside.add(node.id)
        names = {s: name for s in result.free_symbols if (name := _NAMES.get(s, s.name)) in inside}
        if isinstance(result, sp.Expr):
            returned = plain_arithmetic(result, names)
        else:
            parts = "".join(f"        {plain_arithmetic(part, names)},\n" for part in result)
            returned = f"(\n{parts}    )"
        lines[last.lineno - 1 : last.end_lineno] = [f"    return {returned}\n"]
    return "".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Write impact.py next to this file, or return 1 if `--check` finds a difference."""
    parser = argparse.ArgumentParser(
        prog="python -m longball.model.derivation",
        description="Write impact.py from the derived impulse.",
    )
    parser.add_argument("--check", action="store_true", help="write nothing; fail on a difference")
    check = parser.parse_args(arguments).check
    target, text = _impact(), generate()
    if not check:
        target.write_text(text, encoding="utf-8")
    elif target.read_text(encoding="utf-8") != text:
        print(
            f"{target} differs from the derivation; "
            "run `python -m longball.model.derivation` to write it again.",
            file=sys.stderr,
        )
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
