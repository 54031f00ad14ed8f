"""Error bounds that the chain states for a quantity before it decides.

The number system listens: of each question it keeps the value and its error, which the tests work
out again from the numbers of the result. Doubles round by 2^-53, and a state of the reference
engine is off by 2e-14 of its size.
"""

from __future__ import annotations

import json
import math
import random
from dataclasses import dataclass, field
from typing import Any

import mpmath
import pytest

from longball.engines.batch import Batch
from longball.engines.chain import approach_of, solve
from longball.engines.enclosure import Enclosure
from longball.engines.engine import Engine
from longball.engines.event import BatSection, ground, margin_error, past, plate, vertical
from longball.engines.ivp import Ivp
from longball.model.frame import Frame
from longball.model.law import PlaneState
from longball.model.numbers import DOUBLES, Doubles, Undecided
from longball.model.result import Result
from longball.model.scene import AtBatScene, PitchScene, Scene, Swing, parse_scene
from longball.model.scene import Pitch as PitchBlock

HALF_ULP, ERROR = 2.0**-53, Ivp().flight_error


class Listening(Doubles):
    """Doubles that keep every question."""

    def __init__(self) -> None:
        self.asked: dict[str, list[tuple[float, float]]] = {}

    def positive(self, x: float, error: float, question: str) -> bool:
        self.asked.setdefault(question.removeprefix("whether "), []).append((x, error))
        return super().positive(x, error, question)


@dataclass(frozen=True)
class Heard(Ivp):
    """The reference engine with numbers that listen."""

    ears: Listening = field(default_factory=Listening)

    @property
    def numbers(self) -> Listening:
        return self.ears


def asked(line: dict[str, Any]) -> tuple[Result, dict[str, list[tuple[float, float]]]]:
    """Solve a scene; return its result, and the values and errors by their questions."""
    engine = Heard()
    result = solve(parse_scene(json.dumps(line)), engine)
    assert result.error is None
    return result, engine.ears.asked


FLIGHT = {
    "kind": "flight",
    "launch": {"position": [10, 2, 3], "velocity": [30, 8, 20]},
    "gravity": 9.8,
}
AT_BAT = {"kind": "at-bat", "pitch": {"aim": [0.1, 1.5]}, "swing": {"height_offset": 0.01}}


def about(found: float, wanted: float, rel: float = 1e-3) -> bool:
    """To a thousandth: errors are no more exact than that."""
    return found == pytest.approx(wanted, rel=rel, abs=0)


# --- events ---------------------------------------------------------------------------------------


def test_the_sizes_that_errors_of_events_are_relative_to() -> None:
    """The largest length that comes in, and at least 1 m."""
    low, high = PlaneState(0.0, 0.5, 30.0, 9.0), PlaneState(0.0, 70.0, 30.0, 9.0)
    assert ground(0.25, low, DOUBLES).size == 1.0
    assert ground(-9.0, low, DOUBLES).size == 9.0
    assert ground(0.25, high, DOUBLES).size == 70.0
    ahead, aside = Frame(18.0, 0.0, -1.0, 0.0), Frame(18.0, 30.0, -0.6, -0.8)
    assert (plate(ahead, low, DOUBLES).size, plate(ahead, low, DOUBLES).slope) == (18.0, 1.0)
    # Of a flight at an angle: x changes by that part of the way, which is 30 m.
    slanted = plate(aside, low, DOUBLES)
    assert (slanted.size, slanted.slope) == (pytest.approx(18.0), 0.6)
    near = plate(Frame(0.25, 30.0, -0.6, -0.8), low, DOUBLES)
    assert near.size == pytest.approx(0.6)
    assert slanted.place(low).s == pytest.approx(30.0)
    assert past(ahead, 0.07, DOUBLES).size == 18.0
    assert past(Frame(0.5, 0.0, -1.0, 0.0), 3.0, DOUBLES).size == 3.0
    assert vertical(low, DOUBLES).size == 1.0
    assert vertical(PlaneState(0.0, 1.0, 0.25, -0.5), DOUBLES).size == 0.75


# --- the bat --------------------------------------------------------------------------------------


def test_meeting_the_bat() -> None:
    result, questions = asked(AT_BAT)
    contact, impact = result.contact, result.impact
    assert contact is not None
    assert contact.normal is not None
    assert contact.bat_velocity is not None
    assert contact.position is not None
    assert impact is not None
    ((inside, error),) = questions["the ball meets the bat or its end"]
    assert inside == 0.5 - abs(float(contact.position[1]))
    assert about(error, 0.5 * (ERROR + 2 * HALF_ULP))
    ((closing, error),) = questions["ball and bat approach or separate"]
    assert closing == -float(contact.normal_speed)  # type: ignore[arg-type]
    approach = approach_of(parse_scene(json.dumps(AT_BAT)), Ivp())
    assert approach is not None
    assert approach.touch.state is not None
    velocity = approach.pitch.frame.velocity(approach.touch.state)
    pairs = [(v[i], contact.normal[i]) for v in (velocity, contact.bat_velocity) for i in (0, 2)]
    parts = sum(abs(float(v) * float(n)) for v, n in pairs)
    assert about(error, parts * (ERROR + 6 * HALF_ULP))


def test_an_impact_that_is_given_has_the_errors_of_roundings_alone() -> None:
    line = {
        "kind": "impact",
        "incoming": {"position": [0.0696, 0.1, 1], "velocity": [-40, 3, -5], "bat_height": 1},
    }
    _, questions = asked(line)
    ((inside, error),) = questions["the ball meets the bat or its end"]
    assert (inside, error) == (0.4, 0.0)
    ((_, error),) = questions["ball and bat approach or separate"]
    # The bat's end of 0.6 m moves at 34 rad/s, tilted by 5°; the normal is that of x.
    bat = 34 * 0.4 * math.cos(math.radians(5))
    assert about(error, 6 * HALF_ULP * (40 + bat))


def test_the_error_of_the_margin_of_a_grip_is_more_than_its_roundings_and_not_much_more() -> None:
    """The impulse that friction may give, less that which grips, against thirty digits."""
    draw = random.Random(5)
    shares = []
    for _ in range(60):
        friction, restitution = draw.uniform(0.5, 4.0), draw.uniform(-1.0, 1.0)
        height = 1.0 + 0.0696 * math.sin(0.3)
        line = {
            "kind": "impact",
            "bat": {"friction": friction, "tangential_restitution": restitution},
            "incoming": {
                "position": [0.0696 * math.cos(0.3), draw.uniform(-0.4, 0.4), height],
                "velocity": [draw.uniform(-50, -30), draw.uniform(-5, 5), draw.uniform(-5, 5)],
                "spin": [draw.uniform(-200, 200) for _ in range(3)],
                "bat_height": 1.0,
            },
        }
        _, questions = asked(line)
        ((margin, error),) = questions["the ball grips the bat or slides on it"]
        assert error > 0
        truth = solve(parse_scene(json.dumps(line)), Enclosure(30)).impact
        assert truth is not None
        if truth.mode == "grip":
            with mpmath.workdps(30):
                share, impulse = (
                    mpmath.mpf(number.value)  # type: ignore[union-attr]
                    for number in (truth.friction_margin, truth.impulse)
                )
                shares.append(float(abs(margin - share * friction * impulse) / error))
    assert len(shares) > 20
    assert 1e-3 < max(shares) < 1


def test_the_error_of_a_launch_off_the_bat() -> None:
    """Five times the errors of velocity and contact, of both speeds; carried to the landing."""
    result, questions = asked(AT_BAT)
    approach = approach_of(parse_scene(json.dumps(AT_BAT)), Ivp())
    assert approach is not None
    contact, landing = result.contact, result.landing
    assert contact is not None
    assert contact.normal is not None
    assert contact.bat_velocity is not None
    assert contact.time is not None
    assert landing is not None
    assert approach.touch.state is not None
    velocity = approach.pitch.frame.velocity(approach.touch.state)
    speed, towards = (
        math.hypot(*velocity),
        abs(sum(map(lambda a, b: a * float(b), velocity, contact.normal))),
    )
    moved = margin_error(approach.bat, approach.pitch.flight.state.z, ERROR, DOUBLES) / 0.0696
    turned = moved * speed / towards
    assert turned < math.sqrt(2 * moved)  # no graze
    error = 5 * (ERROR + moved + turned) * (speed + math.hypot(*map(float, contact.bat_velocity)))
    flight = float(landing.hang_time)
    asked_twice = questions["the ball touches the ground in the time limit"]
    left, found = asked_twice[-1]
    assert about(found, error * flight)
    assert about(left, (60.0 - flight) * abs(float(landing.velocity[2])))


def test_where_the_touching_is_told_from_across() -> None:
    """A height far above the place across leaves fewer digits of the way up than the reach does."""
    frame = Frame(0.5, 0.0, -1.0, 0.0)
    bat = BatSection(frame, 1e6, 0.07)
    above = math.sqrt(0.07**2 - 0.01**2)
    ball = PlaneState(0.49, 1e6 + above, 30.0, 0.0)
    across, up = bat.offset(ball, DOUBLES)
    assert across == pytest.approx(0.01, rel=1e-13, abs=0)
    assert up == pytest.approx(above, rel=1e-13, abs=0)
    assert up != ball.z - 1e6
    _, down = bat.offset(ball._replace(z=1e6 - above), DOUBLES)
    assert down == -up
    # Not where the ball does not touch, is beside the bat, or is as well known by its height.
    for z, s in ((1e6 + 2 * above, 0.49), (1e6 + 0.005, 0.56)):
        other = PlaneState(s, z, 30.0, 0.0)
        assert bat.offset(other, DOUBLES)[1] == other.z - 1e6
    near = BatSection(Frame(18.0, 0.0, -1.0, 0.0), 1.0, 0.07)
    ball = PlaneState(17.99, 1.0 + above, 30.0, 0.0)
    assert near.offset(ball, DOUBLES)[1] == ball.z - 1.0


# --- the fence ------------------------------------------------------------------------------------


@pytest.mark.parametrize("velocity", [(30, 2, 25), (30, -9, 30)])
def test_clearing_the_fence(velocity: tuple[float, ...]) -> None:
    """Of 1 m and the coordinates, made larger by the steepness of the ball and of the top."""
    launch = {"position": [1, 2, 3], "velocity": velocity}
    fence_of_two = {"polyline": [[40, 30, 2], [50, -40, 4]]}
    result, questions = asked(FLIGHT | {"launch": launch, "fence": fence_of_two, "air": None})
    fence = result.fence
    assert fence is not None
    x, y, z = map(float, fence.position)
    u, v, w = map(float, fence.velocity)
    slope = 2.0 / math.hypot(10.0, 70.0)
    ((clearance, error),) = questions["the ball clears the fence"]
    assert clearance == float(fence.clearance)
    steepness = abs(w) / math.hypot(u, v) + slope
    # A few roundings come in besides the error of the flight: a twentieth of it.
    assert about(error, ERROR * (1 + abs(x) + abs(y) + abs(z)) * (1 + steepness), rel=0.1)
    question = "on which side the ball passes a vertex where the fence ends or has two heights"
    ((aside, error),) = questions[question]
    # So far the ends of the fence lie beside the way.
    beside = [
        abs((px - 1) * velocity[1] - (py - 2) * velocity[0]) / math.hypot(*velocity[:2])
        for px, py in ((40, 30), (50, -40))
    ]
    assert aside == pytest.approx(min(beside), rel=1e-13)
    # A launch that is given has its heading to a few roundings.
    assert 3 * HALF_ULP < error / (1 + abs(x) + abs(y)) < 20 * HALF_ULP
    ((fair, error),) = questions["the ball leaves the field fair"]
    assert fair == abs(y) - x
    assert about(error, ERROR * (abs(x) + abs(y)), rel=0.1)


def test_a_ball_that_lift_turns_back_meets_the_fence_behind_it() -> None:
    """Launched forwards and up, on a circle of some 13 m; the fence ends behind it, at y = 30."""
    sides = [[40, 30, 1], [40, -30, 1], [-8, -30, 1], [-8, 30, 1]]
    line = {
        "kind": "flight",
        "launch": {"position": [1, 2, 3], "velocity": [20, 1, 34]},
        "air": {"drag_coefficient": 0, "lift_coefficient": 4},
        "gravity": 1.0,
        "fence": {"polyline": sides},
    }
    result, questions = asked(line)
    assert result.fence is not None
    assert result.fence.segment == 2
    x, y, _ = map(float, result.fence.position)
    assert (x, y) == pytest.approx((-8.0, 2.0 - 9.0 / 20.0), rel=1e-12)
    question = "on which side the ball passes a vertex where the fence ends or has two heights"
    ((aside, _),) = questions[question]
    assert aside == pytest.approx((9.0 * 1 + 28.0 * 20) / math.hypot(20.0, 1.0), rel=1e-13)
    assert float(result.fence.margin) == pytest.approx(30 - y, rel=1e-13)  # type: ignore[arg-type]


def test_a_ball_that_lands_in_the_field_is_fair_or_foul() -> None:
    line = FLIGHT | {"fence": {"radius": 900.0}}
    result, questions = asked(line)
    assert result.landing is not None
    x, y, _ = map(float, result.landing.position)
    ((fair, error),) = questions["the ball lands fair"]
    assert fair == abs(y) - x
    assert about(error, ERROR * (abs(x) + abs(y)), rel=0.1)


# --- the numbers themselves -----------------------------------------------------------------------


def test_what_lies_within_its_error_is_not_decided() -> None:
    for x, error, wanted in ((1.0, 0.5, True), (-1.0, 0.5, False), (0.0, 0.0, False)):
        assert DOUBLES.positive(x, error, "whether") is wanted
    for x in (0.5, -0.5, 0.0):
        with pytest.raises(Undecided, match=r"whether it is cannot be decided in double precision"):
            DOUBLES.positive(x, 0.5, "whether it is")


# --- ties, on either side of the stated error -----------------------------------------------------

ENGINES = pytest.mark.parametrize("engine", [Ivp(), Batch()], ids=["ivp", "batch"])
REACH = 0.0366 + 0.033


def level_pitch(x: float, offset: float) -> Scene:
    """Without air and gravity, so that the ball stays at 1.8 m; the bat is `offset` above that."""
    return AtBatScene(
        id="level",
        air=None,
        gravity=0.0,
        pitch=PitchBlock(release=(x, 0.0, 1.8), aim=(0.0, 1.8)),
        swing=Swing(height_offset=offset),
    )


@ENGINES
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("share", [-1.05, -0.95, 0.0, 0.95, 1.05])
def test_a_graze_is_decided_beyond_the_error_of_its_margin(
    engine: Engine, side: float, share: float
) -> None:
    """The margin is `share` of what `margin_error` says."""
    error = 2 * REACH * ERROR + HALF_ULP * (8 * (1.8 + REACH) + 4 * 18.44 + 2 * REACH)
    result = solve(level_pitch(18.44, side * (REACH - share * error)), engine)
    if abs(share) < 1:
        assert "whether the ball touches the bat cannot be decided" in str(result.error)
    else:
        assert result.error is None
        assert (result.outcome == "missed") is (share < 0)
    assert result.contact is not None
    assert float(result.contact.margin) == pytest.approx(share * error, abs=4e-16)


@ENGINES
@pytest.mark.parametrize(
    ("share", "said"),
    [
        (-1.05, "the ball starts inside the bat: "),
        (-0.95, "whether the ball starts inside the bat or touches it cannot be decided"),
        (0.0, ""),
        (0.95, "whether the ball starts inside the bat or touches it cannot be decided"),
        (1.05, ""),
    ],
)
def test_a_release_next_to_the_bat_is_decided_beyond_the_error(
    engine: Engine, share: float, said: str
) -> None:
    error = 2 * REACH * ERROR + HALF_ULP * (8 * 1.8 + 4 * REACH + 2 * REACH)
    result = solve(level_pitch(REACH + share * error, 0.0), engine)
    assert str(result.error or "").startswith(said)
    assert (result.error is None) is (said == "")
    if not said:
        assert result.impact is not None


@ENGINES
@pytest.mark.parametrize(
    ("height", "outcome", "said"),
    [
        (-5e-14, "grounded", ""),  # 4.5e-13 m before the plate
        (-3e-14, None, "the ball touches the ground before the ball reaches the plate"),
        (0.0, None, "the ball touches the ground before the ball reaches the plate"),
        (3.6e-14, None, "the ball reaches the plate before the ball touches the ground"),
        (4.4e-14, "crossed", ""),
    ],
)
def test_plate_and_ground_are_told_apart_beyond_the_error(
    engine: Engine, height: float, outcome: str | None, said: str
) -> None:
    """A straight line from 2 m high and 18 m away: errors of 4e-14 m up, and of 3.6e-13 m along."""
    pitch = PitchBlock(release=(18.0, 0.0, 2.0), aim=(0.0, height))
    result = solve(PitchScene(id="line", air=None, gravity=0.0, pitch=pitch), engine)
    assert result.outcome == outcome
    assert said in str(result.error or "")


@pytest.mark.parametrize(("share", "told"), [(0.2, False), (2.0, True)])
def test_a_wind_aloft_is_reached_or_not_to_within_the_error_of_its_height(
    share: float, told: bool
) -> None:
    """Without forces of the air, 40 m/s up reach 80 m above the start under 10 m/s²."""
    wind = {"velocity": [5, 0, 0], "above": 100.0 * (1 + share * ERROR)}
    line = {
        "kind": "flight",
        "launch": {"position": [0, 0, 20], "velocity": [10, 0, 40]},
        "air": {"drag_coefficient": 0.0, "lift_coefficient": 0.0, "wind": wind},
        "gravity": 10,
    }
    result = solve(parse_scene(json.dumps(line)), Ivp())
    assert (result.error is None) is told
    if not told:
        assert "above which the wind blows" in str(result.error)
