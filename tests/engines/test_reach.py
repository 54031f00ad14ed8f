"""The time for which a series is accurate: series with known coefficients, and narrow crises."""

import math

import pytest

from longball.engines.batch import Batch
from longball.engines.chain import solve
from longball.engines.enclosure import Enclosure
from longball.engines.ivp import Ivp
from longball.engines.reach import reach_of_crisis, reach_of_root, reach_of_terms
from longball.model.air import Air, CrisisDrag
from longball.model.scene import FlightScene, Launch

ORDER, RTOL = 12, 1e-16
ULPS = 8 * 2.0**-52  # roundings of a power and a root
RADIUS = 2.5  # of convergence, s


def geometric(first: float, radius: float) -> list[float]:
    """Coefficients of ``first / (1 - t/radius)``."""
    return [first * radius**-k for k in range(ORDER + 1)]


SERIES = geometric(3e-20, RADIUS)
CONSTANT = [1e-10] + [0.0] * ORDER


@pytest.mark.parametrize(
    ("rows", "first"),
    [
        ([SERIES], 0),
        ([CONSTANT, SERIES], 0),  # each component of a large vector counts by itself
        ([geometric(1e-300, RADIUS / 10), SERIES], 0),  # RTOL times 1e-300 is below doubles
        ([[0.0, *SERIES[1:]]], 1),  # from rest
    ],
)
def test_the_last_terms_of_a_geometric_series(rows, first):
    """(t/R)^n is RTOL times the first term that is not zero, (t/R)^first."""
    found = reach_of_terms(rows, ORDER, RTOL, tuple(range(len(rows))))
    assert found == pytest.approx(RADIUS * RTOL ** (1 / (ORDER - 1 - first)), rel=ULPS, abs=0.0)


@pytest.mark.parametrize("missing", [ORDER - 1, ORDER])
def test_one_of_the_last_two_terms_is_zero(missing):
    row = [0.0 if k == missing else x for k, x in enumerate(SERIES)]
    other = 2 * ORDER - 1 - missing
    found = reach_of_terms([row], ORDER, RTOL, (0,))
    assert found == pytest.approx(RADIUS * RTOL ** (1 / other), rel=ULPS, abs=0.0)


def test_a_step_on_a_circle():
    """For (cos t, sin t), the second term t²/2 is twice the size 1 at t = 2."""
    cosine = [(1, 0, -1, 0)[k % 4] / math.factorial(k) for k in range(41)]
    sine = [(0, 1, 0, -1)[k % 4] / math.factorial(k) for k in range(41)]
    assert reach_of_terms([cosine, sine], 40, RTOL, (0, 1)) == pytest.approx(2.0, rel=ULPS, abs=0.0)


def test_other_rows_do_not_count():
    assert reach_of_terms([SERIES, CONSTANT], ORDER, RTOL, (1,)) == math.inf


def test_coefficients_beyond_doubles_have_no_reach():
    assert math.isnan(reach_of_terms([[*SERIES[:-1], math.inf]], ORDER, RTOL, (0,)))


EVEN = [3.0, 0.0, 8 / 3]  # V² = 9 + 16 t², with zeros at ±3i/4


@pytest.mark.parametrize(
    ("rows", "parts", "distance"),
    [
        ([EVEN], None, 0.75),
        ([[3.0, 2.0, 8 / 3]], None, 3 / math.sqrt(20)),  # V² = 9 + 12 t + 20 t²
        ([EVEN, [3.0, 0.0], [0.0, 4.0]], (1, 2), 0.75),  # V = |(3, 4t)|
        ([[3.0, 2.0, 0.0], [3.0, 2.0]], (1,), 1.5),  # V = |3 + 2t|
        ([EVEN, [3.0, 0.0], [0.0, 1.0]], (1, 2), 3.0),  # the larger of two distances
        ([[3.0, 0.0, 0.0]], None, math.inf),
    ],
)
def test_half_the_distance_to_the_zeros_of_a_square(rows, parts, distance):
    assert reach_of_root(5.0, rows, 0, parts) == pytest.approx(
        min(5.0, distance / 2), rel=ULPS, abs=0.0
    )
    assert reach_of_root(0.25, rows, 0, parts) == 0.25


# --- drag crises ----------------------------------------------------------------------------------


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_far_exponent_gets_half_of_the_way_in_each_of_its_terms(sign):
    order = 20
    near = 2 * order - 10  # 30
    assert reach_of_crisis(9.0, [[sign * (near + 8), -sign * 2.0, 0.0]], 0, order) == 2.0  # 4 of 8
    assert reach_of_crisis(9.0, [[sign * (near + 8), 0.0, sign * 4.0]], 0, order) == 1.0
    assert reach_of_crisis(9.0, [[sign * (near + 8), 1e-9, 1e-9]], 0, order) == 9.0  # long enough
    assert reach_of_crisis(9.0, [[sign * (near + 1), 100.0, 100.0]], 0, order) == 9.0  # it shows


@pytest.mark.parametrize("width", [0.2, 0.05])
@pytest.mark.parametrize("velocity", [(40.0, 0.0, 20.0), (0.1, 0.0, 0.0)])
def test_no_step_jumps_over_a_narrow_drag_crisis(width, velocity):
    """The ball starts far above the crisis, or far below; all terms of it are tiny there."""
    scene = FlightScene(
        id="crisis",
        launch=Launch(position=(0.0, 0.0, 90.0), velocity=velocity),
        air=Air(drag_coefficient=CrisisDrag(law="crisis", width=width, speed=25.0)),
    )
    proven = float(solve(scene, Enclosure(15)).landing.distance.value)
    for engine in (Ivp(), Batch(), Batch(1e-6)):
        # A tolerance is for flights of 200 m.
        off = getattr(engine, "tolerance", 0.0)
        assert solve(scene, engine).landing.distance == pytest.approx(proven, rel=1e-12, abs=off)
