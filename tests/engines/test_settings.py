"""Settings of the engines: what is taken if nothing is said, and where their limits are."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from flint import arb

from longball.convergence.report import Limit
from longball.engines import create
from longball.engines.batch import Batch
from longball.engines.chain import approach_of, solve, solve_with_path, solve_with_restitutions
from longball.engines.enclosure import Enclosure
from longball.engines.enclosure.system import static_values, structure
from longball.engines.event import Event
from longball.engines.ivp import Ivp
from longball.engines.path_engine import PathEngine
from longball.engines.polynomial import PolynomialPiece
from longball.engines.verlet import Verlet
from longball.model.law import Law, State
from longball.model.readings import SamplingReading
from longball.model.scene import (
    AtBatScene,
    FlightScene,
    Launch,
    Pitch,
    Swing,
    parse_scene,
)
from longball.model.trace import Program, log, parameter, sqrt, variable

# --- defaults and limits --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "setting", "taken", "refused"),
    [
        ("batch", "tolerance", (1e-14, 1e-4), (0.99e-14, 1.01e-4)),
        ("enclosure", "digits", (1, 500), (0, 501)),
        ("multiprecision", "digits", (1, 290), (0, 291)),
        ("verlet", "dt", (1e-300, 1e300), (0.0, math.inf)),
    ],
)
def test_the_limits_of_settings(
    name: str, setting: str, taken: tuple[float, ...], refused: tuple[float, ...]
) -> None:
    for value in taken:
        assert getattr(create(name, **{setting: value}), setting) == value
    for value in refused:
        with pytest.raises(ValueError, match=setting):
            create(name, **{setting: value})


def test_the_limits_of_tolerances() -> None:
    smallest = 100 * np.finfo(float).eps
    for rtol, atol in ((smallest, 1e-300), (0.999, 0.999)):
        # Pitches were off by 2.3 tolerances with one-step methods, and by 70 with the others.
        assert 2.3 < Ivp("RK45", rtol, atol).flight_error / max(rtol, atol) < 23
        assert 70 < Ivp("BDF", rtol, atol).flight_error / max(rtol, atol) < 700
    for rtol in (0.999 * smallest, 1.0, 1.5):
        with pytest.raises(ValueError, match="rtol = "):
            Ivp("RK45", rtol)
    for atol in (0.0, 1.0, 1.5):
        with pytest.raises(ValueError, match="atol = "):
            Ivp("RK45", atol=atol)
    for value in ("offset_spread", "cell_width"):
        assert SamplingReading(**{value: 1e-9})
        with pytest.raises(ValueError, match="greater than 0"):
            SamplingReading(**{value: 0.0})


def test_no_number_of_a_report_is_nan() -> None:
    kept: dict[str, Any] = {"scene": "a", "quantity": "b", "value": (1.0,), "off": None}
    assert Limit(**kept, error=0.5).error == 0.5
    for bad in (math.nan, math.inf):
        with pytest.raises(ValueError, match="finite"):
            Limit(**kept, error=bad)


def test_the_order_of_the_batch_engine_grows_with_its_digits() -> None:
    """The cheapest is half the logarithm of the truncation; a step has costs besides.

    Positions are off by 11 truncations at most, or by 3 half ulps.
    """
    for tolerance in (1e-4, 1e-9, 1e-14):
        engine = Batch(tolerance)
        assert engine.truncation < tolerance / 11
        assert 0 <= engine.order + 0.5 * math.log(engine.truncation) < 10
        assert 1 < engine.flight_error / max(11 * engine.truncation, 3 * 2.0**-53) < 10


# --- what no other scene comes to -----------------------------------------------------------------


def test_pitches_that_miss_miss_with_every_ball() -> None:
    scene = AtBatScene(id="over", swing=Swing(height_offset=0.5))
    results = solve_with_restitutions(scene, (0.3, 0.4, 0.5), Ivp())
    assert results == [solve(scene, Ivp())] * 3
    assert results[0].outcome == "missed"


def test_a_ball_that_lands_after_the_time_limit_in_its_last_step_is_airborne() -> None:
    """It falls from 1 m at 1/1.1 m/s: in the step from 0.9 s to 1.2 s, after the limit of 1 s."""
    launch = Launch(position=(0.0, 0.0, 1.0), velocity=(2.0, 0.0, -1 / 1.1))
    scene = FlightScene(id="late", air=None, gravity=0.0, time_limit=1.0, launch=launch)
    result, way = solve_with_path(scene, Verlet(0.3))
    assert result.outcome == "airborne"
    assert way.end == pytest.approx(0.9)
    assert way.at(way.end)[0] == pytest.approx((1.8, 0.0, 1 - 0.9 / 1.1))
    longer = scene.model_copy(update={"time_limit": 1.15})
    assert solve(longer, Verlet(0.3)).outcome == "landed"


def test_a_ball_that_nothing_moves_rests_on_the_ground_in_steps_too() -> None:
    launch = Launch(position=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0))
    result = solve(FlightScene(id="rest", air=None, gravity=0.0, launch=launch), Verlet(0.05))
    assert result.landing is not None
    assert result.landing.time == 0.0


@pytest.mark.parametrize("name", ["ivp", "batch", "enclosure", "multiprecision", "verlet"])
def test_a_table_of_the_spin_parameter_without_spin_is_its_first_value(name: str) -> None:
    table = {"law": "table", "of": "spin_parameter", "at": [0.1, 0.3], "values": [0.5, 0.3]}
    launch = {"position": [0, 0, 1], "velocity": [30, 0, 20], "spin": [0, 0, 0]}
    line = {"kind": "flight", "launch": launch}
    by_table = parse_scene(json.dumps(line | {"air": {"drag_coefficient": table}}))
    constant = parse_scene(json.dumps(line | {"air": {"drag_coefficient": 0.5}}))
    engine = create(name)
    found, wanted = solve(by_table, engine).landing, solve(constant, engine).landing
    assert found is not None
    assert wanted is not None
    assert float(found.distance) == pytest.approx(float(wanted.distance), rel=1e-14)


@pytest.mark.parametrize(("node", "told"), [(20.0, False), (19.9999, True), (20.0001, True)])
def test_a_node_that_the_airspeed_only_touches_is_not_proven_to_be_passed(
    node: float, told: bool
) -> None:
    """20 m/s at the apex. No force acts on either side of the node: in doubles it is no matter."""
    table = {"law": "table", "of": "speed", "at": [node, 90], "values": [0, 0]}
    line = {
        "kind": "flight",
        "launch": {"position": [0, 0, 1], "velocity": [20, 0, 10]},
        "air": {"drag_coefficient": table, "lift_coefficient": 0},
    }
    scene = parse_scene(json.dumps(line))
    assert solve(scene, Ivp()).outcome == "landed"
    proven = solve(scene, Enclosure())
    if told:
        assert proven.outcome == "landed"
    else:
        assert "whether the airspeed passes a node of a table" in str(proven.error)


@dataclass(frozen=True)
class Cut(Ivp):
    """Flies in a straight line, in pieces that end at some times; looks for the bat on those."""

    ends: tuple[float, ...] = ()

    def steps(
        self,
        law: Law,
        start: State,
        begin: float,
        limit: float,
        events: Sequence[Event],
    ) -> Iterator[PolynomialPiece]:
        state = np.array(start)
        for end in (*self.ends, limit):
            slopes = [*state[2:], 0.0, 0.0]
            piece = PolynomialPiece(begin, end - begin, law.state, np.column_stack([state, slopes]))
            yield piece
            begin, state = end, np.array(piece.at(end - begin))

    def views(self, *given: Any) -> Iterator[Any]:
        return PathEngine.views(self, *given)


@pytest.mark.parametrize("ends", [(), (0.5,), (0.25, 0.5, 0.75), (0.498,), (0.5, 0.502)])
@pytest.mark.parametrize(("offset", "touched"), [(0.03, True), (-0.03, True), (0.08, False)])
def test_a_bat_is_met_wherever_the_pieces_of_a_pitch_join(
    ends: tuple[float, ...], offset: float, touched: bool
) -> None:
    """The pitch is nearest to the bat after 0.5 s, over the plate, and touches it before."""
    pitch = Pitch(release=(16.0, 0.0, 1.75), aim=(0.0, 1.75), speed=32.0)
    swing = Swing(height_offset=offset)
    scene = AtBatScene(id="cut", air=None, gravity=0.0, pitch=pitch, swing=swing)
    approach = approach_of(scene, Cut(ends=ends))
    assert approach is not None
    touch = approach.touch
    assert touch.touched is touched
    assert touch.margin == pytest.approx(0.0696 - abs(offset), abs=1e-15)
    if touched:
        before = math.sqrt(0.0696**2 - offset**2) / 32
        assert touch.time == pytest.approx(0.5 - before, rel=1e-13)


# --- the structure of a law -----------------------------------------------------------------------


def test_what_depends_on_parameters_alone_has_its_value() -> None:
    k, q, u = parameter("k"), parameter("q"), variable("u")
    static = [k + q, k * q, k / q, sqrt(k), log(q), k + 1.5]
    program = Program(("u",), ("k", "q"), tuple(node * u for node in static))
    functions = {"sqrt": arb.sqrt, "log": arb.log}
    values = static_values(program, {"k": arb(4), "q": arb(8)}, functions)
    wanted = [12.0, 32.0, 0.5, 2.0, math.log(8.0), 5.5]
    assert [float(values[node]) for node in static] == pytest.approx(wanted, rel=1e-15)


def test_linear_rates_that_nothing_depends_on_are_integrals() -> None:
    k, s, u, w = parameter("k"), variable("s"), variable("u"), variable("w")
    program = Program(("s", "r", "u", "w"), ("k",), (k + 2 * u - w, s * u, -(u * w), u))
    found = structure(program)
    assert found.quadratures == {}  # r needs s, by a product
    program = Program(("s", "r", "u", "w"), ("k",), (k + 2 * u - w, w, -(u * w), u))
    found = structure(program)
    assert found.core.variables == ("u", "w")
    (rest, terms), (no_rest, one) = found.quadratures["s"], found.quadratures["r"]
    assert rest is k
    assert {node: float(c.args[0]) for c, node in terms} == {u: 2.0, w: -1.0}
    assert (float(no_rest.args[0]), [node for _, node in one]) == (0.0, [w])
