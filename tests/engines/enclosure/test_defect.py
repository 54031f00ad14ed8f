"""The defect of polynomials is bounded, whatever the polynomials, and by no more than need be.

In each case a polynomial is made wrong on purpose, for one node of a law. All else is as exact as a
long series makes it, so that what is left out of the bound for that node, or lost on the way from
it to the rate, leaves a bound far below the truth.
"""

from __future__ import annotations

import math

import flint
import pytest
from flint import arb, arb_poly, arb_series

from longball.engines.enclosure import Balls
from longball.engines.enclosure.defect import TRANSCENDENTAL, Defect, dynamic, polynomial_of
from longball.engines.enclosure.system import static_values
from longball.model import trace
from longball.model.law import law_with
from longball.model.trace import exp, log, sqrt, variable

BALLS = Balls(30)
ORDER, START, H = 40, 1.0, 0.125
TIMES = [H * n / 8 for n in range(9)]


@pytest.fixture(autouse=True)
def _precise():
    cap = flint.ctx.cap  # the order of arb_series
    flint.ctx.cap = ORDER
    with BALLS.arithmetic():
        yield
    flint.ctx.cap = cap


def series_of(node, value):
    """Return the power series of a node whose arguments are polynomials or numbers."""
    a, *more = (
        value[x] if x.static else arb_series(value[x].coeffs(), prec=ORDER) for x in node.args
    )
    series = a / more[0] if node.kind == "quotient" else getattr(a, node.kind)()
    return arb_poly([c.mid() for c in series.coeffs()])


def wrong(function, kind, order, size):
    """Return bound and truth of the defect of ``s' = f(z)``, where z is the time since `START`.

    The polynomial of the one node of a kind is off by ``size t^order``, which later nodes take on;
    s is the integral of what then stands for f(z), so that nothing else is amiss.
    """
    program = trace.trace(lambda s, z, k: (function(z, k), 1.0), ("s", "z"), ("k",))
    strengths = {"k": arb(0.75)}
    static = static_values(program, strengths, BALLS.functions)
    polynomials = {variable("s"): arb_poly([]), variable("z"): arb_poly([START, 1.0])}
    value = {**static, **polynomials}
    for node in dynamic(program):
        if node.kind in TRANSCENDENTAL:
            polynomials[node] = series_of(node, value)
            if node.kind == kind:
                polynomials[node] += arb_poly([0] * order + [size])
        value[node] = polynomials.get(node) or polynomial_of(node, value)
    rate = value[program.outputs[0]]
    polynomials[variable("s")] = rate.integral()
    defect = Defect(program, static, polynomials)
    rates = program.bind(strengths, BALLS.functions)
    truth = max(abs(rate(arb(t)) - rates(arb(0), START + arb(t))[0]) for t in TIMES)
    return float(defect.bounds(arb(H))[0]), float(truth)


@pytest.mark.parametrize("size", [1e-9, -1e-3])
@pytest.mark.parametrize(
    ("lemma", "function", "kind", "order"),
    [
        ("root_error: r", lambda y, k: sqrt(y), "sqrt", 0),
        ("root_error: r", lambda y, k: sqrt(y), "sqrt", 2),
        ("root_error: e", lambda y, k: sqrt(exp(y)), "exp", 0),
        ("quotient_error: r", lambda y, k: k / y, "quotient", 0),
        ("quotient_error: r, from below zero", lambda y, k: y / (y - 3.0), "quotient", 1),
        ("quotient_error: e_a", lambda y, k: exp(y) / (y + 1.0), "exp", 0),
        ("quotient_error: e_b", lambda y, k: y / exp(y), "exp", 0),
        ("exponential_error: start", lambda y, k: exp(k * y), "exp", 0),
        ("exponential_error: r", lambda y, k: exp(k * y), "exp", 1),
        ("exponential_error: e", lambda y, k: exp(sqrt(y)), "sqrt", 0),
        ("logarithm_error: start", lambda y, k: log(y), "log", 0),
        ("logarithm_error: r", lambda y, k: log(y), "log", 1),
        ("logarithm_error: e", lambda y, k: log(1.0 + sqrt(y)), "sqrt", 0),
        ("product_error: |b| e_a", lambda y, k: y * sqrt(y), "sqrt", 0),
        ("product_error: |a| e_b", lambda y, k: sqrt(y) * y, "sqrt", 0),
        ("product_error: both", lambda y, k: sqrt(y) * sqrt(y), "sqrt", 0),
        ("combination_error", lambda y, k: 2.0 * y - 3.0 * sqrt(y) + k, "sqrt", 0),
    ],
)
def test_a_wrong_node_is_in_the_bound(lemma, function, kind, order, size):
    bound, truth = wrong(function, kind, order, size)
    # A root's bound is twice its error; the rest is how much values change in the time H.
    assert truth <= bound <= 3 * truth, lemma


@pytest.mark.parametrize("kind", ["sqrt", "quotient", "exp", "log"])
def test_without_a_fault_only_roundings_are_left(kind):
    functions = {
        "sqrt": lambda y, k: sqrt(y),
        "quotient": lambda y, k: k / y,
        "exp": lambda y, k: exp(y),
        "log": lambda y, k: log(y),
    }
    # The series of √y about 1 converges as H^40 = 1e-36.
    bound, truth = wrong(functions[kind], kind, 0, 0.0)
    assert truth <= bound < 1e-34


def test_a_root_that_starts_from_zero():
    # y = t: N = t + c t² for √(y y) is off by c t².
    program = trace.trace(lambda x, y: (sqrt(y * y), 1.0), ("s", "z"), ())
    (root,) = (node for node in program.nodes if node.kind == "sqrt")
    static = static_values(program, {}, BALLS.functions)

    def bound(y, n):
        polynomials = {
            variable("s"): arb_poly(n).integral(),
            variable("z"): arb_poly(y),
            root: arb_poly(n),
        }
        return Defect(program, static, polynomials).bounds(arb(H))[0]

    c = 2.0**-10
    assert c * H**2 <= bound([0, 1], [0, 1, c]) <= 2.1 * c * H**2
    assert bound([0, 1], [0, 1]) == 0
    assert 0.5 <= bound([0.5], [0]) <= 0.51  # N = 0 for √0.25
    # A constant under a root that starts as t is nowhere within a bounded ratio of it.
    assert not bound([0.5, 1], [0, 1]) < 1e300


@pytest.mark.parametrize("which", ["u", "w", "speed"])
def test_the_paper_s_law_in_each_of_its_equations(which):
    # A wrong u, a wrong w, and a pair that solves the equations with a wrong speed.
    drag, lift, gravity, assumed = 0.0075, 0.0037, 9.8, 50.0
    law = law_with({"drag": arb(drag), "lift": arb(lift), "gravity": arb(gravity)})
    program = law.program
    u, w = [30.0, -400.0], [20.0, 300.0]
    rate_u = -assumed * (drag * u[0] + lift * w[0])
    rate_w = -assumed * (drag * w[0] - lift * u[0]) - gravity
    u[1] = rate_u if which != "u" else 5.0
    w[1] = rate_w if which != "w" else 5.0
    speed = assumed if which == "speed" else math.hypot(u[0], w[0])
    (root,) = (node for node in program.nodes if node.kind == "sqrt")
    zero = arb_poly([])
    named = {"s": zero, "z": zero, "u": arb_poly(u), "w": arb_poly(w)}
    polynomials = {**{variable(n): p for n, p in named.items()}, root: arb_poly([speed])}
    static = static_values(program, law.strengths, BALLS.functions)
    h = 1e-6  # s; so short that only the first terms count, as if the rest were exact
    bounds = Defect(program, static, polynomials).bounds(arb(h))
    bound = math.hypot(*map(float, bounds[2:]))
    rates = law.rates(BALLS)
    for t in (0.0, h):
        state = [p(arb(t)) for p in named.values()]
        du, dw = rates(*state)[2:]
        missed = math.hypot(float(u[1] - du), float(w[1] - dw))
        assert bound / 5 < missed <= bound
