"""Error bounds that the chain states for a quantity before it decides.

Doubles round by 2^-53, and a state of the reference engine is off by 2e-14 of its size.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, get_args

import pytest
from flint import arb

from longball.engines.batch import Batch
from longball.engines.chain import solve
from longball.engines.enclosure import Balls, Enclosure
from longball.engines.engine import Engine
from longball.engines.ivp import Ivp
from longball.model.numbers import Doubles
from longball.model.result import Outcome
from longball.model.scene import (
    Air,
    AtBatScene,
    Bat,
    FlightScene,
    Launch,
    Pitch,
    PitchScene,
    Scene,
    Swing,
    parse_scene,
)
from tests.scenes import cases_of

HALF_ULP, ERROR = 2.0**-53, Ivp().flight_error


def heard(engine: Any, kind: Any, *arguments: Any) -> tuple[Any, dict[str, list[Any]]]:
    """An engine with numbers that keep every question, and the values and errors by question."""
    asked: dict[str, list[Any]] = {}

    class Listening(kind):  # type: ignore[misc]
        def positive(self, x: Any, error: Any, question: str) -> bool:
            asked.setdefault(question.removeprefix("whether "), []).append((x, error))
            return bool(super().positive(x, error, question))

    class Heard(type(engine)):  # type: ignore[misc]
        numbers = Listening(*arguments)

        def finer(self) -> Iterator[Any]:
            return iter(())

    return replace(Heard(), **vars(engine)), asked


# Every how many cases of a family are asked.
ASKED = {"fence": 3, "impact-oblique": 4, "at-bat": 20}
QUESTIONS = (
    "ball and bat approach or separate",
    "ball and bat jam",
    "on which side the ball passes a vertex where the fence ends or has two heights",
    "the ball clears the fence",
    "the ball grips the bat or slides on it",
    "the ball lands fair",
    "the ball leaves the field fair",
    "the ball meets the bat or its end",
    "the ball passes the bat before the ball touches the ground",
    "the ball reaches the fence before it touches the ground",
    "the ball reaches the plate before the ball touches the ground",
    "the ball touches the ground in the time limit",
)
SHORT = (
    "errors of some batted balls are larger than stated, up to twice: fair, approach or separate"
)


def shares(asked: dict[str, int]) -> dict[str, list[float]]:
    """Differences between doubles and balls of 30 digits, in stated errors, by question."""
    found: dict[str, list[float]] = {question: [] for question in QUESTIONS}
    for family, every in asked.items():
        for case in cases_of(family)[::every]:
            engine, told = heard(Ivp(), Doubles)
            proving, proven = heard(Enclosure(30), Balls, 30)
            if solve(case.scene, engine).error or solve(case.scene, proving).error:
                continue
            for question in told.keys() & proven.keys() & found.keys():
                if len(told[question]) == len(proven[question]):  # looked for in as many pieces
                    found[question] += [
                        abs(float(arb(x) - value)) / error
                        for (x, error), (value, _) in zip(
                            told[question], proven[question], strict=True
                        )
                        if error
                    ]
    return found


def test_a_stated_error_holds_and_is_not_a_thousand_times_too_large() -> None:
    for question, found in shares(ASKED).items():
        assert 1e-3 < max(found) < 1, question


def turned(part: Any) -> Any:
    """A part of a scene that is turned by a right angle about the plate."""
    if isinstance(part, dict):
        return {key: turned(value) for key, value in part.items()}
    if isinstance(part, list) and isinstance(part[0], float):
        x, y, z = part
        return [-y, x, z]
    return [*map(turned, part)] if isinstance(part, list) else part


def test_a_stated_error_is_the_same_in_every_direction() -> None:
    compared = 0
    for case in cases_of("fence")[:: ASKED["fence"]]:
        line, told = json.loads(case.scene.model_dump_json()), []
        if case.scene.kind != "flight" or case.id == "fence-up":  # straight up has no direction
            continue
        for _ in range(4):
            engine, asked = heard(Ivp(), Doubles)
            solve(parse_scene(json.dumps(line)), engine)
            told.append(asked)
            line = turned(line)
        for question in told[0]:
            if "fair" not in question:
                errors = [[error for _, error in asked.get(question, ())] for asked in told]
                assert errors == [pytest.approx(errors[0], rel=1e-6, abs=0)] * 4, (case, question)
                compared += len(errors[0])
    assert compared > 50


def test_the_error_of_a_grip_is_that_of_its_impulses() -> None:
    """Slips that are off by d change P_n by m (1 + ẽ) d and P_t by m (1 + |e_T|) d, at most.

    Each changes P_t, and its limit, the friction times P_n.
    """
    errors, changes = [], []
    for m, e, e_t, friction in (
        (0.145, 0.5, 0.0, 1.0),
        (2.9, 0.5, 0.0, 1.0),
        (0.145, 0.0, 0.0, 1.0),
        (0.145, 0.5, -0.75, 1.0),
        (0.145, 0.5, 0.0, 30.0),
    ):
        line = {
            "kind": "impact",
            "ball": {"mass": m, "restitution": e},
            "bat": {"friction": friction, "tangential_restitution": e_t},
            "incoming": {"position": [REACH, 0, 1], "velocity": [-40, 0, 9], "bat_height": 1},
            "reading": {"bat_ball_restitution": "nathan"},  # ẽ = e
        }
        engine, asked = heard(Ivp(), Doubles)
        solve(parse_scene(json.dumps(line)), engine)
        ((_, error),) = asked["the ball grips the bat or slides on it"]
        errors.append(error)
        changes.append((1 + friction) * m * ((1 + e) + (1 + abs(e_t))))
    share = errors[0] / changes[0]
    assert errors == pytest.approx([share * change for change in changes], rel=1e-12, abs=0.0)


def test_the_error_of_a_normal_grows_with_its_slant_to_the_path() -> None:
    """A shift of the path turns the normal by the shift over the cosine of the slant."""
    errors = []
    for offset in (0.0, 0.8 * REACH):
        engine, asked = heard(Ivp(), Doubles)
        solve(level_pitch(18.44, offset).model_copy(update={"bat": Bat(friction=0.5)}), engine)
        errors += [error for _, error in asked["the ball grips the bat or slides on it"]]
    shift = (2 * REACH * ERROR + HALF_ULP * (8 * (1.8 + REACH) + 4 * 18.44 + 2 * REACH)) / REACH
    straight, slanted = (ERROR + shift + shift / cosine for cosine in (1.0, 0.6))
    # Roundings of the impulses are 1 % of these.
    assert errors[1] / errors[0] == pytest.approx(slanted / straight, rel=0.01)


@pytest.mark.nightly
@pytest.mark.xfail(reason=SHORT, strict=True)
def test_a_stated_error_holds_in_scenes_of_all_kinds() -> None:
    assert {
        q: max(found) for q, found in shares({"various-real": 4}).items() if max(found) > 1
    } == {}


# --- ties, on either side of the stated error -----------------------------------------------------

REACH = 0.0366 + 0.033


def level_pitch(x: float, offset: float) -> Scene:
    """Without air and gravity, so that the ball stays at 1.8 m; the bat is `offset` above that."""
    return AtBatScene(
        id="level",
        air=None,
        gravity=0.0,
        pitch=Pitch(release=(x, 0.0, 1.8), aim=(0.0, 1.8)),
        swing=Swing(height_offset=offset),
    )


def line(x: float, z: float, height: float) -> Scene:
    """A straight pitch from (x, z), m, to a height at the plate."""
    pitch = Pitch(release=(x, 0.0, z), aim=(0.0, height))
    return PitchScene(id="line", air=None, gravity=0.0, pitch=pitch)


def flight(z: float, u: float, w: float, limit: float = 60.0, **more: Any) -> Scene:
    launch = Launch(position=(0.0, 0.0, z), velocity=(u, 0.0, w))
    return FlightScene(id="tie", launch=launch, time_limit=limit, **{"air": None} | more)


def aloft(share: float) -> Scene:
    """Without forces of the air, 40 m/s up reach 80 m above the start under 10 m/s²."""
    wind = {"velocity": (5.0, 0.0, 0.0), "above": 100.0 * (1 + share * ERROR)}
    air = Air.model_validate({"drag_coefficient": 0.0, "lift_coefficient": 0.0, "wind": wind})
    return flight(20.0, 10.0, 40.0, air=air, gravity=10.0)


def sinking(share: float, sink: float) -> Scene:
    """A ball that sinks slowly to the ground, about when its time is over.

    Of its way of 200 m eight half ulps are kept in the height, which it sinks through in time.
    Those of the place where its last step begins, which is not quite as far.
    """
    air, height = Air(lift_coefficient=0.0), 4 * sink
    landing: Any = solve(flight(height, 60.0, -sink, air=air, gravity=0.0), Batch()).landing
    kept = 8 * HALF_ULP * float(landing.position[0]) / abs(float(landing.velocity[2]))
    limit = float(landing.time) + share * kept
    return flight(height, 60.0, -sink, limit, air=air, gravity=0.0)


def closing(share: float) -> Scene:
    """An impact on the level of the bat's axis, on which the ball is almost as fast as the bat.

    Six roundings of either speed are in their difference.
    """

    def impact(u: float) -> Scene:
        incoming = {"position": [REACH, 0, 1], "velocity": [u, 0, 0], "bat_height": 1}
        return parse_scene(json.dumps({"kind": "impact", "incoming": incoming}))

    contact: Any = solve(impact(-1.0), Ivp()).contact
    return impact(contact.bat_velocity[0] * (1 + share * 12 * HALF_ULP))


def over(share: float) -> Scene:
    """A straight line upwards by 1 in 2 over a fence, whose top rises across it by 1 in 4.

    It is 32 m away and 17 m high. An error of the place, of that size and a metre, is one of the
    height by both slopes.
    """
    error = (ERROR + 8 * HALF_ULP) * (1 + 32 + 17)
    top = 17.0 - share * error * (1 + 1 / 2 + 1 / 4)
    fence = {"polyline": [[32, 24, top + 6], [32, -24, top - 6]]}
    launch = {"position": [0, 0, 1], "velocity": [30, 0, 15]}
    line = {"kind": "flight", "air": None, "gravity": 0, "launch": launch, "fence": fence}
    return parse_scene(json.dumps(line))


MARGIN = 2 * REACH * ERROR + HALF_ULP * (8 * (1.8 + REACH) + 4 * 18.44 + 2 * REACH)
CLOSE = 2 * REACH * ERROR + HALF_ULP * (8 * 1.8 + 4 * REACH + 2 * REACH)
BAT, INSIDE = (
    "whether the ball touches the bat",
    "whether the ball starts inside the bat or touches it",
)
GROUND, LIMIT = "lies within its error 2e-14", "the ground in the time limit"
ABOVE = "above which the wind blows"
OVER = "whether the ball clears the fence"
CLOSING = "whether ball and bat approach or separate"

# A scene of a number, and what becomes of it for some numbers: an outcome, or a question that the
# engine declines to decide.
TIES: dict[str, tuple[Any, dict[float, str]]] = {
    # The margin, in its stated errors.
    **{
        f"graze {side:+}": (
            lambda share, side=side: level_pitch(18.44, side * (REACH - share * MARGIN)),
            {-1.05: "missed", -0.95: BAT, 0.0: BAT, 0.95: BAT, 1.05: touched},
        )
        for side, touched in ((1, "separating"), (-1, "airborne"))
    },
    "release": (
        lambda share: level_pitch(REACH + share * CLOSE, 0.0),
        {-1.05: "starts inside the bat: ", -0.95: INSIDE, 0.0: "airborne", 0.95: INSIDE,
         1.05: "airborne"},
    ),
    # From 2 m high and 18 m away: errors of 4e-14 m up, and of 3.6e-13 m along.
    "plate or ground": (
        lambda height: line(18.0, 2.0, height),
        {-5e-14: "grounded",  # 4.5e-13 m before the plate
         -3e-14: "the ball touches the ground before the ball reaches the plate",
         0.0: "the ball touches the ground before the ball reaches the plate",
         3.6e-14: "the ball reaches the plate before the ball touches the ground",
         4.4e-14: "crossed"},
    ),
    # Level and without gravity; the error after 60 s is said to be 2e-14 m.
    "glide": (
        lambda height: flight(height, 30.0, 0.0, gravity=0.0),
        {1e-17: GROUND, 1.9e-14: GROUND, 2.1e-14: "airborne"},
    ),
    # A parabola of 1 s, or of 4 s: errors of 2e-14 m, and of as large a part of the time limit.
    **{
        f"time limit, {rise} m/s": (
            lambda later, rise=rise: flight(0.0, 3.0, rise, rise / 4.9 + later),
            ends,
        )
        for rise, ends in (
            (4.9, {-5e-15: "airborne",  # 2.5e-14 m above the ground
                   -3e-15: LIMIT, 0.0: LIMIT, 1.9e-14: LIMIT, 2.1e-14: "landed"}),
            (19.6, {-3e-15: "airborne", -1e-15: LIMIT, 7e-14: LIMIT, 9e-14: "landed"}),
        )
    },
    **{
        f"sinking at {sink} m/s": (
            lambda share, sink=sink: sinking(share, sink),
            {0.2: LIMIT, 1.5: "landed"},
        )
        for sink in (1e-3, 1e-4)
    },
    "aloft": (aloft, {0.2: ABOVE, 2.0: "landed"}),
    "over a fence": (
        over, {-1.05: "wall", -0.95: OVER, 0.0: OVER, 0.95: OVER, 1.05: "home_run"},
    ),
    "closing": (
        closing,
        {-1.2: "struck", -0.8: CLOSING, 0.0: CLOSING, 0.8: CLOSING, 1.2: "separating"},
    ),
}  # fmt: skip


@pytest.mark.parametrize("engine", [Ivp(), Batch()], ids=["ivp", "batch"])
def test_a_tie_is_decided_beyond_the_stated_error(engine: Engine) -> None:
    for tie, (scene, ends) in TIES.items():
        for number, end in ends.items():
            result = solve(scene(number), engine)
            if end in get_args(Outcome):
                assert result.outcome == end, (tie, number, result.error)
            else:
                assert result.outcome is None, (tie, number)
                assert end in str(result.error), (tie, number)
            if tie.startswith("graze"):
                assert result.contact is not None
                margin = number * MARGIN
                assert float(result.contact.margin) == pytest.approx(margin, abs=4e-16), tie
