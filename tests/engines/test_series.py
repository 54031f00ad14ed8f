"""The recurrence is held to the equations of motion that it restates."""

import mpmath
import pytest

from longball.engines.series import recurrence
from longball.model import trace
from longball.model.law import law_with
from longball.model.trace import ZERO

ORDER = 20
MPMATH = {"sqrt": mpmath.sqrt, "exp": mpmath.exp, "log": mpmath.log}


def thinning(motion, p):
    """Drag in air that thins out with height."""
    thin = trace.exp(-motion.position[2] / p.scale_height)
    u, v, w = (-(thin * motion.speed) * x for x in motion.velocity)
    return u, v, w


def saturating(motion, p):
    """A quotient by 1 + V, which differs by a constant from V."""
    return ZERO, ZERO, p.saturating * motion.speed / (1 + motion.speed)


def inverse(motion, p):
    """A quotient of a constant by a value, and one of equal factors."""
    z = motion.position[2] + 3
    return p.inverse / (z * z), ZERO, ZERO


def wind(motion, p):
    """Drag against a wind: a second size of a vector, which is not zero at rest."""
    u, v, w = motion.velocity
    u = u - p.wind
    speed = trace.sqrt(u * u + v * v + w * w)
    return -u * speed / 128, -v * speed / 128, -w * speed / 128


def shear(motion, p):
    """A wind that grows as the logarithm of height."""
    return p.shear * trace.log(motion.position[2] + 2) * motion.speed, ZERO, ZERO


def bowl(motion, p):
    """√(1 + s²), which is no size of a vector."""
    s = motion.position[0]
    return -p.bowl * s / trace.sqrt(1 + s * s), ZERO, ZERO


def central(motion, p):
    """A pull towards a point: √(x² + (z - 1)²), whose parts are a variable and a difference."""
    s, _, z = motion.position
    z = z - 1
    distance = trace.sqrt(s * s + z * z)
    return -p.central * s * distance, ZERO, -p.central * z * distance


def aside(motion, p):
    """Out of the plane."""
    u, v, w = motion.velocity
    return -p.aside * motion.speed * v, p.aside * motion.speed * u, p.aside * v * w


PAPER = {"drag": 0.0075, "lift": 0.0037, "gravity": 9.8}
MADE_UP = {
    "scale_height": (thinning, 100.0),
    "saturating": (saturating, 3.0),
    "inverse": (inverse, 5.0),
    "wind": (wind, 4.0),
    "shear": (shear, 0.01),
    "bowl": (bowl, 2.0),
    "central": (central, 0.5),
    "aside": (aside, 0.01),
}
LAWS = {
    "all": law_with(PAPER),
    "no lift": law_with({"drag": 0.0075, "gravity": 9.8}),
    "topspin": law_with({"lift": -0.0037, "gravity": 9.8}),
    "weightless": law_with({"drag": 0.0075, "lift": 0.0037}),
    **{
        name: law_with({**PAPER, name: strength}, (force,))
        for name, (force, strength) in MADE_UP.items()
    },
    "everything": law_with(
        {**PAPER, **{name: strength for name, (_, strength) in MADE_UP.items()}},
        [force for force, _ in MADE_UP.values()],
    ),
    "wind alone": law_with({"gravity": 9.8, "wind": 4.0}, (MADE_UP["wind"][0],)),
}
VELOCITIES = [(30.0, 20.0), (0.0, 25.0), (-12.0, -31.0), (0.0, 0.0)]


def expanded(law, velocity, functions, number):
    """Return the coefficients of the variables up to ORDER."""
    program = law.program
    series = recurrence(program)
    rows = [[number(0)] * (ORDER + 2) for _ in series.rows]
    start = {"s": 7.0, "y": 0.5, "z": 2.5, "u": velocity[0], "v": 0.0, "w": velocity[1]}
    for row, name in zip(rows, program.variables, strict=False):
        row[0] = number(start[name])
    strengths = [number(law.strengths[name]) for name in program.parameters]
    series.function(functions, at_rest=velocity == (0.0, 0.0))(rows, ORDER, *strengths)
    return [row[: ORDER + 1] for row in rows[: len(program.variables)]]


def value(coefficients, t):
    return mpmath.polyval(coefficients[::-1], t)


def rate(coefficients, t):
    return value([n * c for n, c in enumerate(coefficients)][1:], t)


@pytest.mark.parametrize("name", LAWS)
def test_series_satisfies_the_equations_of_motion(name):
    # Cut off after order N, the series misses the acceleration by C t^N or less; an error in any
    # of its coefficients by t^(N-1) or more. At 1e-9 s the two are far apart.
    law = LAWS[name]
    for velocity in VELOCITIES:
        if (name, velocity) == ("weightless", (0.0, 0.0)):
            continue  # nothing moves
        with mpmath.workdps(400):
            series = expanded(law, velocity, MPMATH, mpmath.mpf)
            strengths = {name: mpmath.mpf(x) for name, x in law.strengths.items()}
            rates = law.program.bind(strengths, MPMATH)

            def missed(t, series=series, rates=rates):
                wanted = rates(*(value(row, t) for row in series))
                off = [rate(row, t) - x for row, x in zip(series, wanted, strict=True)]
                return mpmath.norm(off)

            t = mpmath.mpf("1e-9")
            assert missed(t) > 0
            assert mpmath.log(missed(t) / missed(t / 2), 2) > ORDER - 0.001, velocity


def test_every_kind_of_node_is_expanded():
    """In laws at rest and not: of two sizes of vectors, one of which is zero at rest, too."""
    nodes = {node.kind for node in LAWS["everything"].program.nodes if not node.static}
    assert nodes == {"variable", "sum", "product", "quotient", "sqrt", "exp", "log"}
    assert len(recurrence(LAWS["wind"].program).roots) == 2
    assert LAWS["aside"].program.variables == tuple("syzuvw")
    assert LAWS["wind"].program.variables == tuple("szuw")
