"""Settings of the engines: what is taken if nothing is said, and where their limits are."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from longball.convergence.report import Limit
from longball.engines import create
from longball.engines.chain import approach_of, solve, solve_with_path
from longball.engines.enclosure import Enclosure
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


# --- what no other scene comes to -----------------------------------------------------------------


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
